# SPDX-License-Identifier: Apache-2.0
"""Tables of a sweep of accuracy: CSV for programs, Markdown for documents."""

import csv
from pathlib import Path

RATES = ("missed", "through", "cracks", "false_hits", "wrong_triangle", "self_hits", "failed")
ERRORS = ("t_ulp", "u_ulp", "v_ulp")


def scene_name(scene: str) -> str:
    """What a scene is called: its file without endings, and how far it is moved."""
    name, at, moved = Path(scene).name.partition("@")
    return name.split(".")[0] + at + moved


def csv_rows(line: dict) -> list[dict]:
    """A row for each kind of rays of a point; one alone where the format cannot hold the scene."""
    point = line["point"]
    shared = {k: point[k] for k in ("scene", "format", "test", "traversal", "seed")}
    end = {
        **line["operators"],
        **{k: line[k] for k in ("operator_lut", "operator_ff", "operator_dsp")},
        **{f"{k}_cycles": v for k, v in line["latency"].items()},
        **{f"{k}_bytes": v for k, v in line["bytes"].items()},
        **{k: line.get("rtl", {}).get(k) for k in ("cycles_per_ray", "mrays_per_s")},
        "rtl_seconds": line.get("rtl", {}).get("seconds"),
        "refused": line.get("refused"),
        "command": line["command"],
    }
    if "refused" in line:
        return [{**shared, **end}]
    picture = line["picture"] or {}
    middle = {
        "triangles": line["triangles"],
        "dropped_triangles": line["dropped"],
        "picture": f"{picture['width']}x{picture['height']}" if picture else "",
        **{k: picture.get(k) for k in ("wrong_pixels", "psnr_db", "flip")},
        "model_seconds": line["model_seconds"],
    }
    rows = []
    for kind in line["kinds"]:
        row = {**shared, "rays": kind["rays"], "count": kind["count"]}
        for name in RATES:
            rate = kind[f"{name}_per_million"]
            row |= {f"{name}_per_million": rate["rate"], f"{name}_high": rate["high"]}
        for name in ERRORS:
            row |= {f"{name}_{k}": v for k, v in kind[name].items()}
        for name in ("steps_per_ray", "tests_per_ray", "restarts_per_ray"):
            row[name] = kind[name]
        rows.append({**row, **middle, **end})
    return rows


def write_csv(path: Path, lines: list[dict]) -> None:
    rows = [row for line in lines for row in csv_rows(line)]
    with path.open("w", newline="") as out:
        table = csv.DictWriter(out, max(rows, key=len), restval="")
        table.writeheader()
        table.writerows(rows)


def write_markdown(path: Path, lines: list[dict]) -> None:
    """Cracks by kind of rays in a million, and what a machine costs."""
    kinds = list(dict.fromkeys(k["rays"] for line in lines for k in line.get("kinds", ())))
    names = [f"cracks, {kind}" for kind in kinds]
    names += ["missed, edges", "wrong, uniform", "t, u, v p99.9, uniform, ulp", "steps, uniform"]
    names += ["wrong pixels", "FLIP", "LUT", "FF", "DSP", "bytes a triangle"]
    names += ["cycles a ray", "Mrays/s"]
    rows = [["scene", "format", "test", "walk", *names]]
    rows.append(["---"] * 4 + ["---:"] * len(names))
    for line in lines:
        point, rtl = line["point"], line.get("rtl")
        of = {kind["rays"]: kind for kind in line.get("kinds", ())}
        picture, uniform = line.get("picture"), of.get("uniform")

        def rate(kind, name, of=of):
            return f"{of[kind][f'{name}_per_million']['rate']:,.0f}" if kind in of else ""

        row = [scene_name(point["scene"]), point["format"], point["test"], point["traversal"]]
        row += [rate(kind, "cracks") for kind in kinds]
        row += [rate("edges", "missed"), rate("uniform", "wrong_triangle")]
        row += [", ".join(f"{uniform[e]['p99_9']:.1f}" for e in ERRORS) if uniform else ""]
        row += [f"{uniform['steps_per_ray']:.1f}" if uniform else ""]
        row += [f"{picture['wrong_pixels']:,}", f"{picture['flip']:.4f}"] if picture else ["", ""]
        row += [f"{line['operator_lut']:,}", f"{line['operator_ff']:,}", str(line["operator_dsp"])]
        row += [str(line["bytes"]["triangle"])]
        row += [f"{rtl['cycles_per_ray']:.2f}", f"{rtl['mrays_per_s']:.1f}"] if rtl else ["", ""]
        rows.append(row)
    path.write_text("".join(f"| {' | '.join(row)} |\n" for row in rows))
