"""Picks the strides that the gait stage starts from: python starts.py data/strides.json SWEEP.json..."""

import json
import sys
from pathlib import Path

rows = [row for path in sys.argv[2:] for row in json.loads(Path(path).read_text())]
base = {(0.0, 0.0), (2e5, 1.0)}
best = {}
for row in rows:
    key = tuple(row[name] for name in ("kind", "k", "c", "brush", "weight", "aim"))
    if (row["k"], row["c"]) not in base and row["weight"] != 1.0:
        continue
    if key not in best or row["cost"] < best[key]["cost"]:
        best[key] = row
lines = []
for key in sorted(best):
    row = {name: best[key][name] for name in ("kind", "k", "c", "brush", "weight", "aim")}
    row["x"] = [float(f"{value:.7g}") for value in best[key]["x"]]
    lines.append(json.dumps(row, separators=(",", ":")))
about = (
    "Starts of the gait stage, not results: strides found by IPOPT on the same problems (benches/gait/sweep.py), cross-seeded "
    "between brushes and weights. The stage solves every problem again from them and certifies what it reports."
)
Path(sys.argv[1]).write_text('{"about":' + json.dumps(about) + ',\n"starts":[\n' + ",\n".join(lines) + "\n]}\n")
print(len(lines), "starts")
