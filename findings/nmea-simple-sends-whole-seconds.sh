#!/bin/sh
# nmea-simple sends ten positions a second with one time, and 34 degrees south as 33 degrees 60 minutes.
#
# nmea-simple 3.3.0 (npm), encodeNmeaPacket of GGA and GLL and parseNmeaSentence. Guess: a position of 12:00:00.9 comes
# back with its time, as the reader takes 120000.90. Seen: 12:00:00.0, as the fraction is cut; at 15 m/s a track of 10
# Hz jumps 15 m once a second. -33.999999999 degrees are 3360.000000,S, which is no valid latitude of NMEA 0183. Exits 1
# if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts nmea-simple@3.3.0
cat >send.cjs <<'JS'
const { encodeNmeaPacket, parseNmeaSentence } = require("nmea-simple");

const { version } = require("nmea-simple/package.json");
const fix = { sentenceId: "GGA", latitude: 47, longitude: 8, fixType: "fix", satellitesInView: 12 };
Object.assign(fix, { horizontalDilution: 0.8, altitudeMeters: 500, geoidalSeperation: 47 });
const times = [0, 1, 9].map((tenths) => {
  const sent = encodeNmeaPacket({ ...fix, time: new Date(Date.UTC(2026, 5, 1, 12, 0, 0, 100 * tenths)) }, "GP");
  return parseNmeaSentence(sent).time.toISOString().slice(11, 23);
});
const body = "GPGLL,4700.0000,N,00800.0000,E,120000.90,A";
const sum = [...body].reduce((code, letter) => code ^ letter.charCodeAt(0), 0).toString(16).toUpperCase();
const read = parseNmeaSentence(`$${body}*${sum.padStart(2, "0")}`).time.toISOString().slice(11, 23);
const place = { sentenceId: "GLL", latitude: -33.999999999, longitude: 8, time: new Date(0), status: "valid" };
const latitude = encodeNmeaPacket(place, "GP").split(",").slice(1, 3).join();
console.log(`nmea-simple ${version}: 12:00:00.0, .1 and .9 come back as ${times}; 120000.90 is read as ${read};`);
console.log(`-33.999999999 is ${latitude}`);
const same = times.every((time) => time === "12:00:00.000");
process.exit(same && read === "12:00:00.900" && latitude === "3360.000000,S" ? 0 : 1);
JS
node send.cjs
