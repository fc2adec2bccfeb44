"""Fills and improves the compliant strides of a file of starts by IPOPT, each problem from its neighbours until nothing gets better.

    python explore.py STARTS.json [SECONDS [sweep|fine|rest]]

STARTS as data/strides.json; rigid strides in it are kept as they are. Written with every stride that is found
or improved, so the work can be interrupted and resumed. The stage certifies what it reports; nothing here is a result.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from stride import Stride
from sweep import BRUSHES, MESH, WEIGHTS, solve

STIFFNESSES, LOSSES = [5e4, 1e5, 2e5, 4e5], [0.3, 1.0, 2.0, 3.0]
BASE, MAP_WEIGHT = (2e5, 1.0), 1.0
# Largest distance in scales of the variables. IPOPT relaxes bounds by 1e-8, and with curvatures of some 1e-4 that moves a stride by
# up to sqrt(1e-8 / 1e-4) = 1e-2; the project's own solver, which polishes, is held to 1e-3.
SAME_MINIMUM = 5e-2
FIELDS = ("k", "c", "brush", "weight", "aim", "choice")
CHOICES = {
    "own": {},
    "short-stance": dict(longest_stance_s=0.06),
    "long-stance": dict(longest_stance_s=0.15),
    "slow-joints": dict(rate_limit=40.0),
    "narrow-hips": dict(hip_deg=(-80, 40)),
    "sharp-friction": {},
    "blunt-friction": {},
    "shallow-foot": dict(foot_depth_m=0.02),
    "fine-mesh": dict(mesh=(56, 16)),
}
SLIP = {"sharp-friction": 0.03, "blunt-friction": 0.3}
FINE_WEIGHTS = [0.01, 0.1, 1.0]
DETOUR = [0.01, 0.1, MAP_WEIGHT]


def problems():
    """Keys in the order in which they can be reached from the smallest weight."""
    keys = [(*BASE, brush, weight, 20.0, "own") for weight in WEIGHTS for brush in BRUSHES]
    keys += [(*BASE, brush, MAP_WEIGHT, 8.0, "own") for brush in BRUSHES]
    keys += [(*BASE, brush, weight, 20.0, "fine-mesh") for weight in FINE_WEIGHTS for brush in ("symmetric", "asymmetric")]
    cells = sorted(((k, c) for k in STIFFNESSES for c in LOSSES if (k, c) != BASE), key=lambda cell: sum(steps(cell)))
    keys += [(*cell, brush, MAP_WEIGHT, 20.0, "own") for cell in cells for brush in BRUSHES]
    keys += [(*BASE, brush, MAP_WEIGHT, 20.0, choice) for choice in CHOICES for brush in ("symmetric", "asymmetric")
             if choice not in ("own", "fine-mesh")]
    return keys


def part_of(key):
    """Part of the work that a problem belongs to."""
    if key[5] == "fine-mesh":
        return "fine"
    return "sweep" if key[:2] == BASE and key[5] == "own" else "rest"


def steps(cell):
    return [abs(values.index(at) - values.index(base)) for values, at, base in zip((STIFFNESSES, LOSSES), cell, BASE)]


def beside(a, b):
    """As Name::is_beside in the Rust crate: one choice differs by one step of its list."""
    apart = abs(STIFFNESSES.index(a[0]) - STIFFNESSES.index(b[0])) + abs(LOSSES.index(a[1]) - LOSSES.index(b[1]))
    apart += (a[2] != b[2]) + abs(WEIGHTS.index(a[3]) - WEIGHTS.index(b[3])) + (a[4] != b[4])
    apart += 0 if a[5] == b[5] else 1 if "own" in (a[5], b[5]) else 2
    return apart == 1


class Book:
    def __init__(self, path):
        self.path = Path(path)
        self.file = json.loads(self.path.read_text())
        self.strides = {}
        self.best, self.version, self.looked, self.solves, self.detoured = {}, {}, {}, 0, set()

    def stride(self, choice):
        """Built when first asked for: the choices that differ in bounds are programmes of their own."""
        program = "own" if choice in SLIP else choice
        if program not in self.strides:
            settings = dict(mesh=MESH, options={"ipopt.max_iter": 250, "ipopt.max_cpu_time": 60.0}) | CHOICES[program]
            self.strides[program] = Stride(**settings)
        return self.strides[program]

    def own_starts(self):
        for row in self.file["starts"]:
            if row["kind"] == "compliant":
                yield tuple(row[field] for field in FIELDS), row

    def take(self, key, row):
        """A row of the file: a stride that an earlier run found, or a start to try."""
        k, c, brush, weight, aim, choice = key
        stride = self.stride(choice)
        x = stride.from_rust(np.array(row["x"]))
        if "found" not in row:
            self.try_start(key, x)
            return
        cost, _ = stride.fun(x, [k, c, SLIP.get(choice, 0.1), *BRUSHES[brush], weight, aim])
        self.best[key] = dict(cost=float(cost), speed=float(stride.get(x, "V")[0]), x=x, found=row["found"], tried=row["tried"])
        self.version[key] = self.solves = self.solves + 1

    def try_start(self, key, x):
        k, c, brush, weight, aim, choice = key
        stride = self.stride(choice)
        x, info = solve(stride, x, k=k, c=c, slip=SLIP.get(choice, 0.1), mu=BRUSHES[brush], weight=weight, aim=aim)
        self.solves += 1
        print(*key, info["status"], info["iterations"], f"{info['time']:.1f} s, cost {info['cost']:.6f}", flush=True)
        old = self.best.get(key)
        tried = old["tried"] + 1 if old else 1
        # An acceptable end is a start as well: the certificate has the last word.
        if not info["ok"]:
            if old:
                old["tried"] = tried
            return False
        if old:
            # One minimum by the distance of the strides, never by their cost.
            same = np.max(np.abs(x - old["x"]) / stride.scale) < SAME_MINIMUM
            if same or info["cost"] >= old["cost"]:
                old["tried"], old["found"] = tried, old["found"] + bool(same)
                return False
        self.best[key] = dict(cost=info["cost"], speed=info["speed"], x=x, found=1, tried=tried)
        self.version[key] = self.solves
        return True

    def improve(self, key):
        if key not in self.best and key not in self.detoured:
            self.detoured.add(key)
            if self.detour(key):
                return True
        near = [other for other in list(self.best) if beside(key, other) and self.version[other] > self.looked.get((key, other), 0)]
        better = False
        for other in near:
            self.looked[key, other] = self.version[other]
            x, mine, theirs = self.best[other]["x"], self.stride(key[5]), self.stride(other[5])
            better |= self.try_start(key, x if mine.intervals == theirs.intervals else mine.read_from(theirs, x))
        return better

    def detour(self, key):
        """From the base contact at the smallest weight, where strides change gently, up to the weight of the map."""
        k, c, brush, _, aim, choice = key
        base = (*BASE, brush, DETOUR[0], aim, "own")
        if aim != 20.0 or base not in self.best or self.stride(choice).intervals != self.stride("own").intervals:
            return False
        x = self.best[base]["x"]
        for weight in DETOUR[:-1]:
            x, info = solve(self.stride(choice), x, k=k, c=c, slip=SLIP.get(choice, 0.1), mu=BRUSHES[brush], weight=weight, aim=aim)
            print("  by", weight, info["status"], info["iterations"], flush=True)
            if info["status"] != "Solve_Succeeded":
                return False
        return self.try_start(key, x)

    def save(self):
        kept = [row for row in self.file["starts"] if row["kind"] == "rigid"]
        for key in problems():
            if key in self.best:
                x = [float(f"{v:.6g}") for v in self.stride(key[5]).to_rust(self.best[key]["x"])]
                kept.append(dict(kind="compliant", **dict(zip(FIELDS, key)),
                                 found=self.best[key]["found"], tried=self.best[key]["tried"], x=x))
        lines = ",\n".join(json.dumps(row, separators=(",", ":")) for row in kept)
        part = self.path.with_suffix(".part")
        part.write_text('{"about":' + json.dumps(self.file["about"]) + ',\n"starts":[\n' + lines + "\n]}\n")
        part.rename(self.path)

    def report(self, what, better):
        speeds = {brush: [round(self.best[key]["speed"], 2) if (key := (*BASE, brush, w, 20.0, "own")) in self.best else None for w in WEIGHTS]
                  for brush in BRUSHES}
        thrice = sum(entry["found"] >= 3 for entry in self.best.values())
        print(what, f"{better} better, {len(self.best)} of {len(problems())}, {thrice} found thrice, {self.solves} solves, "
              f"{time.process_time():.0f} s", speeds, flush=True)


def main():
    book = Book(sys.argv[1])
    limit = float(sys.argv[2]) if len(sys.argv) > 2 else np.inf
    wanted = [key for key in problems() if len(sys.argv) < 4 or part_of(key) == sys.argv[3]]
    for key, row in book.own_starts():
        book.take(key, row)
    book.save()
    book.report("starts", 0)
    filling, better, turn = True, 1, 0
    while (better or filling) and time.process_time() < limit:
        filling, better, turn = filling and better > 0, 0, turn + 1
        for key in wanted:
            if (not filling or key not in book.best) and time.process_time() < limit and book.improve(key):
                better += 1
                book.save()
        book.report(f"round {turn}{' (gaps)' if filling else ''}:", better)


if __name__ == "__main__":
    main()
