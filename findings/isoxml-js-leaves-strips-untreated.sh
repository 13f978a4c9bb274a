#!/bin/sh
# isoxml writes a grid without a cell for a strip of 8 m, with cells of infinite width.
#
# isoxml 1.11.2 of npm, addGridFromGeoJSON of a zone of 222 m to the north, 8 and 15 m to the east, cells of 10 m, the
# default. Guess: the narrow strip has one column. Seen: columns are rounded down, 8 m are 0 columns of width Infinity
# and an empty file, 15 m are one. A drone applies nothing on a strip beside a hedge. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund isoxml@1.11.2 >/dev/null
cat >strip.cjs <<'JS'
const { ISOXMLManager, TAGS, TaskTaskStatusEnum } = require("isoxml");

const grid = (meters) => {
  const east = 8 + meters / 75840; // a degree of longitude at 47 N
  const coordinates = [[[8, 47], [east, 47], [east, 47.002], [8, 47.002], [8, 47]]];
  const zone = { type: "Feature", properties: { rate: 100 }, geometry: { type: "Polygon", coordinates } };
  const manager = new ISOXMLManager();
  const task = manager.createEntityFromAttributes(TAGS.Task, { TaskStatus: TaskTaskStatusEnum.Planned });
  const dose = { ProcessDataDDI: "0001", ProcessDataValue: 0 };
  const variable = manager.createEntityFromAttributes(TAGS.ProcessDataVariable, dose);
  task.addGridFromGeoJSON({ type: "FeatureCollection", features: [zone] }, [variable], ["rate"]);
  const { GridMaximumColumn, GridMaximumRow, GridCellEastSize } = task.attributes.Grid[0].attributes;
  const width = Number.isFinite(GridCellEastSize) ? "finite" : "infinite";
  return `${GridMaximumColumn} by ${GridMaximumRow} ${width}, ${task.attributes.Grid[0].binaryData.length} bytes`;
};
const [narrow, wide] = [grid(8), grid(15)];
console.log(`columns by rows of cells: 8 m ${narrow}; 15 m ${wide}`);
process.exit(narrow === "0 by 22 infinite, 0 bytes" && wide === "1 by 22 finite, 88 bytes" ? 0 : 1);
JS
node strip.cjs
