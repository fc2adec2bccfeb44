"""The sweep of Fig. 12 by both programs: same problems, same starts, one thread each.

    python race.py data/strides.json CERTIFY [own|next|COLD.json]

CERTIFY is the built example of that name (target/release/examples/certify). Starts: `own`, the shipped start of each problem, or
`next`, the shipped start of the problem at the next smaller weight (of the next brush, at the smallest), or one cold start for all
(`compliant.json` of the example `cold_starts`). Times are
processor times of the solves; reading files and building CasADi's functions do not count for IPOPT, reading files does for ours.
Two strides are one minimum by their distance, never by their cost.
"""

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from explore import SAME_MINIMUM
from stride import Stride
from sweep import BRUSHES, MESH, WEIGHTS, solve

CONTACT, AIM = (2e5, 1.0), 20.0


def starts(path, which):
    if which not in ("own", "next"):
        cold = json.loads(Path(which).read_text())
        yield from ((brush, weight, cold) for brush in BRUSHES for weight in WEIGHTS)
        return
    rows = json.loads(Path(path).read_text())["starts"]
    own = {(r["brush"], r["weight"]): r["x"] for r in rows
           if r["kind"] == "compliant" and (r["k"], r["c"]) == CONTACT and r["aim"] == AIM and r["choice"] == "own"}
    brushes = list(BRUSHES)
    for brush in brushes:
        for at, weight in enumerate(WEIGHTS):
            before = (brush, WEIGHTS[at - 1]) if at else (brushes[(brushes.index(brush) + 1) % 3], weight)
            yield brush, weight, own[(brush, weight) if which == "own" else before]


def ours(certify, rows):
    with tempfile.TemporaryDirectory() as folder:
        file, out = Path(folder, "starts.json"), Path(folder, "out.json")
        named = [dict(kind="compliant", k=CONTACT[0], c=CONTACT[1], brush=b, weight=w, aim=AIM, x=list(x)) for b, w, x in rows]
        file.write_text(json.dumps({"starts": named}))
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([certify, file, "300", out], check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text()), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    path, certify, which = sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else "own"
    rows = list(starts(path, which))
    mine, my_seconds = ours(certify, rows)
    stride = Stride(mesh=MESH)
    seconds, agree, same, solved, wins = 0.0, 0, 0, 0, [0, 0]
    for (brush, weight, x), ours_row in zip(rows, mine):
        y, info = solve(stride, stride.from_rust(np.array(x)), k=CONTACT[0], c=CONTACT[1], mu=BRUSHES[brush], weight=weight, aim=AIM)
        seconds += info["time"]
        solved += info["status"] == "Solve_Succeeded"
        apart = np.max(np.abs(y - stride.from_rust(np.array(ours_row["x"]))) / stride.scale)
        gap = info["cost"] / ours_row["cost"] - 1
        both = info["status"] == "Solve_Succeeded" and ours_row["certified"]
        if both and apart < SAME_MINIMUM:
            same += 1
            agree += abs(gap) < 1e-6
        elif both:
            wins[gap < 0] += 1
        print(f"{brush:11} {weight:5} ours {'certified' if ours_row['certified'] else 'open':9} {ours_row['cost']:.8f} in {ours_row['steps']} steps, IPOPT "
              f"{info['status']} {info['cost']:.8f} in {info['iterations']}, apart {apart:.1e}, cost {gap:+.1e}", flush=True)
    print(f"{which} starts: ours {sum(r['certified'] for r in mine)} certified in {my_seconds:.1f} s, IPOPT {solved} solved in {seconds:.1f} s, ratio "
          f"{my_seconds / seconds:.2f}; same minimum {same}, of these agree to 1e-6 {agree}; other minimum: ours cheaper {wins[0]}, IPOPT's {wins[1]}")


if __name__ == "__main__":
    main()
