#!/bin/sh
# DroneDeploy's log parser cuts the place of the remote control to whole degrees, and velocities to whole mph.
#
# @dronedeploy/flight-log-parser 2.2.3 (npm), parseLog of a row of its tab-separated log. Guess: RC Latitude and
# Longitude are as exact as those of the aircraft and of home, and Vel - X as Speed. Seen: of 47.3978 and 8.5456, all
# three times, the remote control gets 47 and 8, 60 km from home; -2.9 and 0.9 mph are -2 and 0.
# Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts @dronedeploy/flight-log-parser@2.2.3
cat >row.cjs <<'JS'
const { parseLog } = require("@dronedeploy/flight-log-parser");
const { version } = require("@dronedeploy/flight-log-parser/package.json");
const row = {
  "Date/Time (UTC)": "2026-06-01T10:00:00",
  "Elapsed Time (sec)": "1.0",
  "Aircraft Latitude (Degrees)": "47.3978",
  "Aircraft Longitude (Degrees)": "8.5456",
  "Home Latitude (Degrees)": "47.3978",
  "Home Longitude (Degrees)": "8.5456",
  "RC Latitude (Degrees)": "47.3978",
  "RC Longitude (Degrees)": "8.5456",
  "Aircraft Speed (mph)": "3.1",
  "Aircraft Vel - X (mph)": "-2.9",
  "Aircraft Vel - Y (mph)": "0.9",
};
const log = `#DroneDeploy 4.0\n${Object.keys(row).join("\t")}\n${Object.values(row).join("\t")}\n`;
parseLog(log).then(({ rows: [read] }) => {
  const numbers = (...names) => names.map((name) => Object.entries(read).find(([key]) => key.startsWith(name))[1]);
  const place = (whose) => numbers(`${whose} Latitude`, `${whose} Longitude`);
  const speeds = numbers("Aircraft Speed", "Aircraft Vel - X", "Aircraft Vel - Y");
  const seen = [place("Aircraft"), place("Home"), place("RC"), speeds];
  console.log(`flight-log-parser ${version}: aircraft, home, remote control, speeds ${JSON.stringify(seen)}`);
  process.exit(JSON.stringify(seen) === "[[47.3978,8.5456],[47.3978,8.5456],[47,8],[3.1,-2,0]]" ? 0 : 1);
});
JS
node row.cjs
