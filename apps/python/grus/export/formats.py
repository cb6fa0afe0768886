# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables and frames as bytes of files: CSV, JSON, NumPy's, MATLAB's; VTK's XML for unstructured grids, STL, OBJ; lines
"x y z r"."""
import base64
import csv
import io
import json
import math

import numpy as np


def table_csv(columns):
    """A number that is not there is an empty field, as spreadsheets want it."""
    text = io.StringIO()
    flat = {f"{name}{'_' + 'xyz'[k] if values.ndim > 1 else ''}": values[:, k] if values.ndim > 1 else values
            for name, values in columns.items() for k in range(values.shape[1] if values.ndim > 1 else 1)}
    out = csv.writer(text, lineterminator="\n")
    out.writerow(flat)
    out.writerows([["" if isinstance(v, float) and math.isnan(v) else f"{v:.10g}" if isinstance(v, float) else v
                    for v in row] for row in zip(*(values.tolist() for values in flat.values()))])
    return text.getvalue().encode()


def table_json(columns):
    plain = {name: [None if isinstance(v, float) and not math.isfinite(v) else v for v in values.tolist()]
             for name, values in columns.items()}
    return json.dumps(plain).encode() + b"\n"


def table_npz(columns):
    data = io.BytesIO()
    np.savez_compressed(data, **columns)
    return data.getvalue()


def table_mat(columns):
    """A struct `grus`; MATLAB's names have 63 letters at most."""
    from scipy.io import savemat
    data = io.BytesIO()
    savemat(data, {"grus": {name[:63]: values for name, values in columns.items()}}, long_field_names=True)
    return data.getvalue()


TYPES = {"f4": "Float32", "f8": "Float64", "i8": "Int64", "u1": "UInt8", "i4": "Int32"}


def array(name, values):
    """A DataArray, little-endian, base64."""
    values = np.ascontiguousarray(values)
    data = values.astype(values.dtype.newbyteorder("<")).tobytes()
    told = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
    kind = TYPES[values.dtype.str[1:]]
    size = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""  # of a number meshio makes a column
    return f'<DataArray type="{kind}" Name="{name}"{size} format="binary">{told}</DataArray>\n'


def vtu(frame):
    """VTK's XML, which ParaView, pyvista, meshio and PyVista read."""
    group = lambda tag, fields: f"<{tag}>\n{''.join(array(k, v) for k, v in fields.items())}</{tag}>\n"
    cells = {"connectivity": frame.connectivity.astype("i8"), "offsets": frame.offsets[1:].astype("i8"),
             "types": frame.types.astype("u1")}
    head = '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
    return ('<?xml version="1.0"?>\n' + head + "<UnstructuredGrid>\n"
            f'<Piece NumberOfPoints="{len(frame.points)}" NumberOfCells="{len(frame.types)}">\n'
            + group("Points", {"Points": frame.points}) + group("Cells", cells) + group("CellData", frame.cells)
            + group("PointData", frame.at_points) + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n").encode()


def stl(frame):
    """Binary STL of all triangles, in millimetres, the unit that programs for solids take it in."""
    corners, _ = frame.triangles()
    x = 1e3 * frame.points.astype(np.float64)[corners]
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    rows = np.zeros(len(x), np.dtype([("numbers", "<f4", 12), ("none", "<u2")]))
    rows["numbers"] = np.concatenate([normal[:, None], x], axis=1).reshape(len(x), 12)
    return b"Grus, mm".ljust(80) + len(x).to_bytes(4, "little") + rows.tobytes()


def spheres(frame):
    """Lines "x y z r" (m) and the box around them, which packing.kind = "file" reads: of what is no sphere the radius
    of equal volume."""
    grains, box = frame.grains(), frame.box()
    low, head = (box[0], "#box {:.7g} {:.7g} {:.7g}\n".format(*box[1])) if box else (0, "")
    rows = np.column_stack([grains["position_m"] - low, grains["radius"]])
    return "".join(["# x y z r (m)\n", head, *(" ".join(f"{v:.9g}" for v in row) + "\n" for row in rows)]).encode()


def obj(frame):
    """An object for each grain, in metres, with the number of its material, which packing.kind = "polyhedra" reads."""
    corners, at = frame.triangles()
    ids = frame.cells["id"][at].astype(np.int64)
    of = frame.cells["material"][at].astype(np.int64) if "material" in frame.cells else np.zeros(len(at), np.int64)
    text, written = ["# Grus, m\n"], 0
    for number in np.unique(ids):
        own = corners[ids == number]
        points, place = np.unique(own, return_inverse=True)
        text += [f"o grain{number}\nusemtl material{of[ids == number][0]}\n",
                 *("v " + " ".join(f"{v:.9g}" for v in frame.points[p]) + "\n" for p in points),
                 *(f"f {a} {b} {c}\n" for a, b, c in place.reshape(-1, 3) + written + 1)]
        written += len(points)
    return "".join(text).encode()


TABLES = {".csv": table_csv, ".json": table_json, ".npz": table_npz, ".mat": table_mat}
FRAMES = {".vtu": vtu, ".stl": stl, ".obj": obj, ".txt": spheres}
