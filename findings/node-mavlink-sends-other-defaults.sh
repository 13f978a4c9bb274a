#!/bin/sh
# A new MissionItemInt of node-mavlink shows command NAV_WAYPOINT, and is sent with command 0.
#
# node-mavlink 2.3.0 with mavlink-mappings. Guess: a field that is not set is sent as the object shows it. Seen: command
# is the text 'NAV_WAYPOINT', whose number is 16; the packet has 0, which is no command. A number that is set is sent.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund node-mavlink@2.3.0 >/dev/null
cat >item.mjs <<'JS'
import { common, MavLinkProtocolV2 } from "node-mavlink";

const COMMAND = 10 + 30; // in the packet: header, four parameters, x, y, z, seq
const sent = (item) => {
  item.autocontinue = 1; // nonzero after the command: nothing before it is cut off
  return new MavLinkProtocolV2().serialize(item, 1).readUInt16LE(COMMAND);
};
const plain = new common.MissionItemInt();
const set = new common.MissionItemInt();
set.command = common.MavCmd.NAV_WAYPOINT;
const seen = [plain.command, sent(plain), sent(set)];
console.log(`shown: ${seen[0]}, sent: ${seen[1]}; if set: ${seen[2]}`);
process.exit(JSON.stringify(seen) === JSON.stringify(["NAV_WAYPOINT", 0, 16]) ? 0 : 1);
JS
node item.mjs
