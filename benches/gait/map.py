"""The map at one speed weight: python map.py BASE.json OUT.json; every contact from the strides of the base and from its neighbours."""

import json
import sys
from pathlib import Path

import numpy as np
from stride import Stride
from sweep import BRUSHES, Book, solve

CELLS = [(1e5, 1.0), (1e5, 2.0), (1e5, 3.0), (2e5, 2.0), (2e5, 3.0), (5e4, 1.0), (5e4, 2.0), (5e4, 3.0)]


def main():
    stride = Stride()
    book = Book(sys.argv[2], stride)
    base = {}
    for row in json.loads(Path(sys.argv[1]).read_text()):
        if (row["k"], row["c"], row["weight"], row["aim"]) == (2e5, 1.0, 1.0, 20.0):
            base[row["brush"]] = stride.from_rust(np.array(row["x"]))
    for k, c in CELLS:
        before = [(k, c - 1.0), (k * 2, c)]
        for turn in range(2):
            for brush, mu in BRUSHES.items():
                goal = dict(kind="compliant", k=k, c=c, brush=brush, weight=1.0, aim=20.0)
                seeds = [base[brush]] if turn == 0 else []
                cells = before if turn == 0 else [(k, c)]
                for other in BRUSHES:
                    for cell in cells:
                        key = ("compliant", *cell, other, 1.0, 20.0)
                        if key in book.rows and (other == brush) == (turn == 0):
                            seeds.append(book.rows[key]["x"])
                for seed in seeds:
                    x, info = solve(stride, seed, k=k, c=c, mu=mu, weight=1.0, aim=20.0)
                    book.offer(("compliant", k, c, brush, 1.0, 20.0), x, info, goal)
        speeds = {b: round(book.rows[key]["speed"], 3) for b in BRUSHES if (key := ("compliant", k, c, b, 1.0, 20.0)) in book.rows}
        print(k, c, speeds, flush=True)
        book.save()


if __name__ == "__main__":
    main()
