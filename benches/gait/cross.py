"""Another round of cross-seeding on one contact: python cross.py SWEEP.json OUT.json KIND K C [ROUNDS]."""

import json
import sys

import numpy as np
from pathlib import Path
from stride import Stride
from sweep import BRUSHES, WEIGHTS, Book, solve


def main():
    source, out, kind, k, c = sys.argv[1], sys.argv[2], sys.argv[3], float(sys.argv[4]), float(sys.argv[5])
    rounds = int(sys.argv[6]) if len(sys.argv) > 6 else 2
    stride = Stride(rigid=kind == "rigid")
    book = Book(out, stride)
    for row in json.loads(Path(source).read_text()):
        if (row["kind"], row["k"], row["c"]) == (kind, k, c):
            key = (kind, k, c, row["brush"], row["weight"], row["aim"])
            book.rows[key] = dict(row, x=stride.from_rust(np.array(row["x"])))
    for turn in range(rounds):
        changed = 0
        for aim, weights in ((20.0, WEIGHTS), (8.0, [1.0])):
            for weight in weights:
                for brush, mu in BRUSHES.items():
                    mine = (kind, k, c, brush, weight, aim)
                    near = [(kind, k, c, b, weight, aim) for b in BRUSHES if b != brush]
                    at = weights.index(weight)
                    near += [(kind, k, c, brush, weights[i], aim) for i in (at - 1, at + 1) if 0 <= i < len(weights)]
                    for key in near:
                        if key not in book.rows:
                            continue
                        before = book.rows.get(mine, {}).get("cost", np.inf)
                        x, info = solve(stride, book.rows[key]["x"], k=k, c=c, mu=mu, weight=weight, aim=aim)
                        book.offer(mine, x, info, dict(kind=kind, k=k, c=c, brush=brush, weight=weight, aim=aim))
                        changed += book.rows.get(mine, {}).get("cost", np.inf) < before * (1 - 1e-6)
            for brush in BRUSHES:
                speeds = [book.rows.get((kind, k, c, brush, w, aim), {}).get("speed", np.nan) for w in weights]
                print(kind, k, c, "round", turn, "aim", aim, brush, f"{np.nanmean(speeds):.3f}", np.round(speeds, 2), flush=True)
            book.save()
        if not changed:
            break


if __name__ == "__main__":
    main()
