#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# evidence.sh TABLE: measure one of the tables of docs/evidence and print it; `make evidence` does all of them.
# Works in the current folder, with HDM05, Bandai-Namco and UP-Fall unpacked there and other data sets in $DATA.
set -euo pipefail

utd=$DATA/imu/utd_mhad/utd_mhad_subjects_1_4.npz
libraries=(hdm05 bandai_namco "$DATA/mixamo" "$DATA/bvh/cmu_DragonForged" "$DATA/bvh/cmu_JonathanAlderson" "$utd")
mhad=(--mhad "$DATA/imu/berkeley_mhad/acc.npz")
umafall=(--umafall "$DATA/imu/umafall/umafall.npz")
others=(--dsads "$DATA/imu/dsads/dsads_acc_gyr_25hz.npz" --upfall up_fall)

# Run what writes files; what it prints is kept for those who look why it failed.
quietly() { "$@" >"$table.log" 2>&1 || { tail -3 "$table.log" >&2; return 1; }; }
tables_of() { sed -n '/^|/p' "$1"; }
# The first analysis of each data set, and of UP-Fall that without what its thighs' tilt decides.
tests_of() { tables_of "$1" | grep -E '^\| data set|^\|---|\| all |sitting'; }
columns() { cut -d'|' -f"$1" | sed 's/|*$/|/'; }

# Rows of `w2w study repeatability`, of whole or drawn libraries, by the names of their columns.
halves() {
  python - "$@" <<'PY'
import sys

kind, *wanted = sys.argv[1:]
print("| library, halved |", " | ".join(wanted), "|")
print("|---" * (1 + len(wanted)) + "|")
names = {"hdm05": "HDM05 by clip", "hdm05 --by-subject": "HDM05 by performer", "bandai_namco": "Bandai-Namco by clip"}
for file in [*names][: 3 if kind == "drawn" else 2]:
    cells = [" ".join(cell.split()) for cell in open(f"{kind} {file}.txt").read().split("|")[1:]]
    cells = [cell for cell in cells if cell]  # lines are broken where a console ends
    size = cells.index("---")
    found = dict(zip(cells[:size], cells[2 * size :]))
    print("|", names[file], "|", " | ".join(found[one] for one in wanted), "|")
PY
}

table=$1
case $table in
truth)
  quietly w2w study truth "${libraries[@]}" "${mhad[@]}" "${umafall[@]}" "${others[@]}" --out truth
  tests_of truth/truth.md | columns 1-3,5-9,14-15
  ;;
transfer) tests_of truth/truth.md | columns 1-3,16-17 ;;
sources) sed -n '/^| activity | sources/,/^$/p;/^## /{/all/!q}' truth/mhad/report.md ;;
challenge)
  given=()
  for each in "${libraries[@]}"; do given+=(--library "$each"); done
  quietly w2w challenge "${mhad[@]}" "${umafall[@]}" "${others[@]}" --utd "$utd" "${given[@]}" --out challenge
  python - <<'PY'
rows = [line.split("|")[1:-1] for line in open("challenge/challenge.md") if line[0] == "|"][2:]
rows = [[cell.strip().split(" (")[0] for cell in row] for row in rows]
sets, methods = (list(dict.fromkeys(row[at] for row in rows)) for at in (0, 1))
found = {(row[0], row[1]): ", ".join(filter(None, (row[3], row[5], row[7]))) for row in rows}
print("| method |", " | ".join(sets), "|")
print("|---" * (1 + len(sets)) + "|")
for method in methods:
    print("|", method, "|", " | ".join(found[one, method] for one in sets), "|")
PY
  ;;
card)
  python - <<'PY'
import os
from matplotlib.figure import Figure

rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in open("truth/truth.md") if line[0] == "|"]
tests = [dict(zip(rows[0], row)) for row in rows[2:] if row[1].startswith("all ")]
rules = {"regret": "W2W"} | {rule: rule for rule in rows[0][rows[0].index("regret") + 1 : rows[0].index("at random") + 1]}
print("| F1 lost against people's best site |", " | ".join(test["data set"] for test in tests), "| mean |")
print("|---" * (2 + len(tests)) + "|")
axes = (figure := Figure(figsize=(7, 0.4 * len(rules) + 0.8), layout="constrained")).subplots()
for y, (column, rule) in enumerate(rules.items()):
    found = [float(test[column].split(" (")[0] or "nan") for test in tests]
    mean = sum(found) / len(found)
    print("|", rule, "|", " | ".join(f"{each:.3f}" for each in [*found, mean]), "|")
    axes.barh(y, mean, color="#2a6f73" if rule == "W2W" else "#c9d1d3", height=0.6)
    axes.plot(found, [y] * len(found), "o", color="#222222", markersize=4, clip_on=False)
axes.set_yticks(range(len(rules)), rules.values())
axes.invert_yaxis()
axes.set_xlabel("F1 lost against people's best site; dots: four data sets, bars: their mean")
axes.spines[["top", "right"]].set_visible(False)
figure.savefig(os.environ["W2W_ROOT"] + "/docs/pictures/truth.png", dpi=130, metadata={"Software": None})
PY
  ;;
utd)
  quietly w2w validate utd-mhad "$utd" --out utd
  python - <<'PY'
found, sites = {}, []
for line in open("utd/report.md"):
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    if line.startswith("## "):
        sites.append(line[3:].split(":")[0])
        wanted = False
    elif cells[:2] == ["real", "real"]:
        found["trained on people"] = [*found.get("trained on people", ()), f"{cells[2]} ({cells[3]})"]
    elif cells:
        wanted = wanted or cells[0].startswith("trained on simulated")
        if wanted and cells[1] not in ("---", "macro F1"):
            found[cells[0]] = [*found.get(cells[0], ()), f"{cells[1]} ({cells[2]})"]
    else:
        wanted = False
print("| trained on simulated signals, tested on a person never seen |", " | ".join(sites), "|")
print("|---" * (1 + len(sites)) + "|")
for name, cells in found.items():
    print("|", name, "|", " | ".join(cells), "|")
PY
  ;;
need)
  quietly w2w study need "${libraries[@]}" "${mhad[@]}" "${others[@]}" --utd "$utd" --out need
  sed -n '/^| rule/,/^$/p' need/needs.md
  ;;
spot)
  quietly w2w run hdm05 --out run_hdm05 --no-pictures --no-report
  for each in "hdm05" "hdm05 --by-subject"; do
    # shellcheck disable=SC2086
    w2w study repeatability run_$each --halvings 4 >"halves $each.txt"
  done
  halves halves expected delivered gain "by raw F1" holds
  ;;
costs) halves halves "as well" lose within heavy "cost holds" ;;
against)
  quietly w2w run bandai_namco --out run_bandai_namco --no-pictures --no-report
  w2w study repeatability run_bandai_namco --drawn --halvings 20 >"drawn bandai_namco.txt"
  w2w study repeatability run_hdm05 --drawn --halvings 12 >"drawn hdm05.txt"
  w2w study repeatability run_hdm05 --drawn --halvings 48 --by-subject >"drawn hdm05 --by-subject.txt"
  halves drawn recommended "belt clip" watch energy random most worse "cost holds"
  ;;
broad)
  echo "| method | nothing fitted: acc r | gyr r | shift, ms | shift and lever arm fitted: acc r | acc RMSE, m/s² |"
  python -m w2w_studies.experiments.broad 2>/dev/null | sed -n '/^|/p' | sed 1d | columns 1-3,5-6,10-11
  ;;
walk)
  python -m w2w_studies.experiments.gait >walk.txt 2>/dev/null
  python - <<'PY'
heads, found = [], {}
for line in open("walk.txt"):
    cells = [cell.strip() for cell in line.split("|")[1:3]]
    if line.startswith("below "):
        band = line.strip()
    elif cells and cells[1] == "mean":
        heads.append(f"{cells[0]}, {band}")
    elif cells and "---" not in cells[0]:
        found[cells[0]] = [*found.get(cells[0], ()), cells[1]]
print("| method |", " | ".join(heads), "|")
print("|---" * (1 + len(heads)) + "|")
for method, means in found.items():
    print("|", method, "|", " | ".join(means), "|")
PY
  ;;
claims)
  quietly w2w study mixamo "$DATA" --labels "$DATA/motions.csv" --out mixamo --no-pictures --no-report
  python - <<'PY'
import csv

def plain(text): return f"{float(text):+.2f}".replace("0.", ".", 1)

print("| claim | difference | verdict |\n|---|---|---|")
for row in csv.DictReader(open("mixamo/trends.csv")):
    found, low, high = (plain(row[name]) for name in ("difference", "low", "high"))
    print("|", row["claim"], "|", f"{found} ({low} to {high})", "|", row["verdict"], "|")
PY
  ;;
rehab)
  quietly w2w study rehab --out rehab_study --no-pictures
  python - <<'PY'
import json

def two(value): return f"{value:.2f}".lstrip("0")
def expected(one): return f"{two(one['expected_f1'])} ({' to '.join(two(end) for end in one['expected_f1_interval'])})"

print("| | which exercise | well or badly |\n|---|---|---|")
found = [json.load(open(f"rehab_study/{part}/summary.json")) for part in ("results", "quality")]
best, worn = ([one[key] for one in found] for key in ("best_single_patch", "worn_together"))
rows = {
    "answer": [one["answer"]["sentence"] for one in found],
    "best single patch": [one["region"] for one in best],
    "expected F1 on other people": [expected(one) for one in best],
    "map reliability": [two(one["map_reliability"]) for one in found],
    "worn together": [", ".join(place["region"] for place in one["places"]) for one in worn],
    "expected F1 together": [expected(one) for one in worn],
}
for name, cells in rows.items():
    print("|", name, "|", " | ".join(cells), "|")
PY
  ;;
*)
  echo "No table is called $table." >&2
  exit 2
  ;;
esac
