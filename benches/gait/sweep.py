"""Sweeps of the gait by IPOPT: seven speed weights, three brushes, several contacts, cross-seeded.

    python sweep.py START_DIR OUT.json [rigid|compliant|fig11]

START_DIR holds cold starts written by `cargo run --release -p biped --example cold_starts`; OUT gets every
stride that converged, in the order of the Rust crate's variables, with IPOPT's iterations and time.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from stride import Stride

FORWARD, REVERSE = 0.9049, 0.4314
MEAN = 0.5 * (FORWARD + REVERSE)
BRUSHES = {"symmetric": (MEAN, MEAN), "asymmetric": (FORWARD, REVERSE), "backwards": (REVERSE, FORWARD)}
WEIGHTS = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0]
MESH = (28, 8)
CELLS = [(2e5, 1.0), (2e5, 0.3), (1e5, 1.0), (5e4, 1.0), (1e5, 2.0), (1e5, 3.0), (2e5, 2.0), (5e4, 3.0)]


class Book:
    """Best strides so far, by cell, brush and weight."""

    def __init__(self, path, stride):
        self.path, self.stride, self.rows = path, stride, {}

    def offer(self, key, x, info, goal):
        if not info["ok"]:
            return None
        old = self.rows.get(key)
        if old is None or info["cost"] < old["cost"] - 1e-7 * abs(old["cost"]):
            self.rows[key] = dict(goal, cost=info["cost"], speed=info["speed"], x=x, found=1,
                                  iterations=info["iterations"], seconds=info["time"])
        elif info["cost"] < old["cost"] + 1e-6 * abs(old["cost"]):
            old["found"] += 1
        return x

    def save(self):
        rows = [dict(r, x=[float(f"{v:.9g}") for v in self.stride.to_rust(r["x"])]) for r in self.rows.values()]
        Path(self.path).write_text(json.dumps(rows))


def solve(stride, x, **settings):
    clock = time.process_time()
    x, info = stride.solve(x, **settings)
    info["time"] = time.process_time() - clock
    return x, info


def sweep(stride, book, kind, k, c, start, aim=20.0, weights=WEIGHTS, passes=2):
    for turn in range(passes):
        for brush, mu in BRUSHES.items():
            x = start[brush] if turn == 0 else None
            order = weights if turn == 0 else weights[::-1]
            for weight in order:
                seeds = []
                if turn == 0:
                    seeds = [x]
                else:
                    seeds = [book.rows[key]["x"] for b in BRUSHES for w in weights
                             if (key := (kind, k, c, b, w, aim)) in book.rows
                             and ((b != brush and w == weight) or (b == brush and 0.2 < w / weight < 5 and w != weight))]
                for seed in seeds:
                    y, info = solve(stride, seed, k=k, c=c, mu=mu, weight=weight, aim=aim)
                    goal = dict(kind=kind, k=k, c=c, brush=brush, weight=weight, aim=aim)
                    got = book.offer((kind, k, c, brush, weight, aim), y, info, goal)
                    if turn == 0 and got is not None:
                        x = got
            speeds = [book.rows.get((kind, k, c, brush, w, aim), {}).get("speed", np.nan) for w in weights]
            print(kind, f"k {k:.0e} c {c} pass {turn} {brush}: mean {np.nanmean(speeds):.3f}", np.round(speeds, 2), flush=True)
        book.save()


def main():
    starts, out, which = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    rigid = which == "rigid"
    stride = Stride(rigid=rigid, mesh=(8, 5) if rigid else MESH)
    book = Book(out, stride)
    x = stride.from_rust(np.array(json.loads((starts / f"{'rigid' if rigid else 'compliant'}.json").read_text())))
    mean = BRUSHES["symmetric"]
    if rigid:
        for weight in (0.002, 0.005, 0.01):
            x, info = solve(stride, x, mu=mean, weight=weight)
            print(weight, info["status"], info["speed"], flush=True)
        sweep(stride, book, "rigid", 0.0, 0.0, dict.fromkeys(BRUSHES, x))
        sweep(stride, book, "rigid", 0.0, 0.0, dict.fromkeys(BRUSHES, x), aim=8.0, weights=[1.0], passes=1)
        book.save()
        return
    for k, c, slip, weight in ((2e4, 0.0, 1.0, 0.002), (5e4, 0.3, 0.3, 0.005), (1e5, 0.6, 0.1, 0.01), (2e5, 1.0, 0.1, 0.01)):
        x, info = solve(stride, x, k=k, c=c, slip=slip, mu=mean, weight=weight)
        print(k, c, info["status"], info["speed"], info["iterations"], flush=True)
    start = dict.fromkeys(BRUSHES, x)
    base = None
    for k, c in CELLS:
        sweep(stride, book, "compliant", k, c, start, passes=2 if base is None else 1)
        base = base or (k, c)
        nearest = {b: book.rows[("compliant", *base, b, WEIGHTS[0], 20.0)]["x"] for b in BRUSHES}
        start = nearest
        if (k, c) == base:
            sweep(stride, book, "compliant", k, c, start, aim=8.0, weights=[1.0], passes=1)
            book.save()


if __name__ == "__main__":
    main()
