#!/bin/sh
# node-mavlink sends a latitude given in degrees as a whole number of 1e-7 degrees, without an error.
#
# node-mavlink 2.3.0, MissionItemInt. Its x is in 1e-7 degrees. Guess: a value with a fraction, as 47.3977418 given by
# mistake, is refused. Seen: 47 is sent, 0.0000047 degrees; the item lies off Africa and a station reports success.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund node-mavlink@2.3.0 >/dev/null
cat >item.mjs <<'JS'
import { common, MavLinkProtocolV2 } from "node-mavlink";

const item = new common.MissionItemInt();
item.command = common.MavCmd.NAV_WAYPOINT;
item.x = 47.3977418;
item.y = 8.5455941;
item.autocontinue = 1;
const packet = new MavLinkProtocolV2().serialize(item, 1);
const seen = [packet.readInt32LE(10 + 16), packet.readInt32LE(10 + 20)];
console.log(`x, y sent: ${seen}`);
process.exit(JSON.stringify(seen) === "[47,8]" ? 0 : 1);
JS
node item.mjs
