#!/bin/sh
# kriging.js finds 371 m between posts of 100 and 250 m, on a plane.
#
# @sakitam-gis/kriging 0.1.0, train and predict with the model and values of its README: exponential, 0, 100. Guess:
# four corners of a square at 100, 200, 300 and 400 m, and its center at 250, are a plane: half-way from the lowest
# corner to the center it is 175 m. Seen: 371 m; 1 m away from the corner of 100 m it is 238. The posts themselves are
# kept. The fitted nugget is -212, so that near posts seem less alike than far ones. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts @sakitam-gis/kriging@0.1.0 >/dev/null
cat >posts.cjs <<'JS'
const { train, predict } = require("@sakitam-gis/kriging");

const [east, north, height] = [[0, 0, 10, 10, 5], [0, 10, 0, 10, 5], [100, 200, 300, 400, 250]];
const fitted = train([...height], east, north, "exponential", 0, 100);
const posts = east.map((x, post) => Math.round(predict(x, north[post], fitted)));
const [between, near] = [predict(2.5, 2.5, fitted), predict(1, 0, fitted)].map(Math.round);
const nugget = Math.round(fitted.nugget);
console.log(`posts ${posts}, between 100 and 250 m: ${between} m, 1 m from 100 m: ${near} m, nugget ${nugget}`);
process.exit(posts.join() === height.join() && between === 371 && nugget === -212 ? 0 : 1);
JS
node posts.cjs
