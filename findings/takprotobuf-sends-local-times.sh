#!/bin/sh
# takprotobuf sends the times of a Cursor on Target event in the time zone of the computer, as UTC.
#
# takprotobuf 0.0.1 with protobuf 3.20.3, and takproto 3.0.1. Guess: a drone's event that is stale at 10:01Z is stale at
# 10:01 UTC, wherever it is sent. Seen: on a computer in New York it is stale at 14:01, in Kolkata at 4:31, before it
# was sent. takproto says 10:01 in both. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for name in takprotobuf takproto; do python3 -m venv "$folder/$name"; done
"$folder/takprotobuf/bin/pip" install -q takprotobuf==0.0.1 protobuf==3.20.3 untangle==1.3.0
"$folder/takproto/bin/pip" install -q takproto==3.0.1
cd "$folder"
cat >event.xml <<'XML'
<event version="2.0" uid="drone-1" type="a-f-A-M-H-Q" how="m-g" time="2026-06-01T10:00:00.000Z"
 start="2026-06-01T10:00:00.000Z" stale="2026-06-01T10:01:00.000Z">
<point lat="47.4" lon="8.5" hae="520.5" ce="5.0" le="9.0"/><detail><track speed="12.0" course="90.0"/></detail></event>
XML
cat >stale.py <<'PY'
import sys
from datetime import UTC, datetime

event = open("event.xml").read()
if sys.argv[1] == "takproto":
    from takproto import parse_proto, xml2proto

    sent = parse_proto(xml2proto(event))
else:
    from takprotobuf import parseProto, xmlToProto

    sent = parseProto(xmlToProto(event))
print(datetime.fromtimestamp(sent.cotEvent.staleTime / 1000, UTC).strftime("%H:%M"))
PY
stale() { TZ=$2 "$folder/$1/bin/python" stale.py "$1"; }
old="$(stale takprotobuf America/New_York) $(stale takprotobuf Asia/Kolkata)"
new="$(stale takproto America/New_York) $(stale takproto Asia/Kolkata)"
echo "stale at 10:01 UTC, sent in New York and in Kolkata: takprotobuf 0.0.1 $old, takproto 3.0.1 $new"
[ "$old" = "14:01 04:31" ] && [ "$new" = "10:01 10:01" ]
