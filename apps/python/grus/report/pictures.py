# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of the last frame without ParaView: grains by generation, fragment or size, the macro mesh by a field; of
grains that cracked point by point."""
import numpy as np
from matplotlib.collections import PolyCollection

from grus.errors import InputError
from grus.figures import plt
from grus.frames import Frame, frame, frames

FACES = {5: [(0, 1, 2)], 9: [(0, 1, 2, 3)], 10: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)],
         12: [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}


def last_frame(folder, what):
    """The last frame of `what` ("grains", "macro"); None without frames, or without h5py."""
    try:
        return frame(folder, what)
    except InputError:
        return None


def view(azimuth=-60, elevation=22):
    """Rows: right, up and towards who looks."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.array([right, np.cross(towards, right), towards])


def corner_normals(points, corners, smooth):
    """Outward unit normals (n, 3, 3) at the corners of triangles: of the surface where it is smooth, of the faces
    otherwise."""
    x = points[corners]
    face = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normal = np.repeat(face[:, None], 3, axis=1)
    if smooth:
        at = np.stack([np.bincount(corners.ravel(), normal[..., k].ravel(), len(points)) for k in range(3)], 1)
        normal = at[corners]
    return normal / np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-300)


def painted(triangles, normals, owner, colours, turn, pixels=720):
    """Image (RGBA) of triangles (n, 3, 3) with normals at their corners, each of an owner with a colour: the nearest in
    each pixel, lit from the upper left, outlines drawn."""
    seen = triangles @ turn.T
    front = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])[:, 2] > 0
    seen, owner = seen[front], owner[front]
    shade = (0.35 + 0.65 * np.clip(normals[front] @ turn.T @ np.array([-0.4, 0.5, 0.77]), 0, 1)).astype(np.float32)
    low, high = seen.reshape(-1, 3).min(0), seen.reshape(-1, 3).max(0)
    scale = (pixels - 9) / max(high[:2] - low[:2])
    width, height = np.ceil((high[:2] - low[:2]) * scale).astype(int) + 9
    at = (seen - low) * scale + [4, 4, 0]
    depth, which = np.full(width * height, -np.inf), np.full(width * height, -1)
    lit = np.zeros(width * height, np.float32)
    edge = np.linalg.norm(at - np.roll(at, 1, axis=1), axis=2).max(1)
    at, depth = at.astype(np.float32), depth.astype(np.float32)
    cuts = np.unique(np.ceil(1.25**np.arange(np.ceil(np.log(max(edge.max(), 1) / 0.75) / np.log(1.25)) +
                                             2))).astype(int)
    level = np.searchsorted(cuts, edge / 0.75)  # points on a triangle lie nearer than a pixel
    for cut in cuts[np.unique(level)]:
        mine = np.flatnonzero(cuts[level] == cut)
        mine = mine[np.argsort(-at[mine, 0, 2])]  # the nearest first: what they hide is dropped unsorted
        i, j = np.meshgrid(np.arange(cut + 1), np.arange(cut + 1))
        u, v = i[i + j <= cut] / cut, j[i + j <= cut] / cut
        weights = np.stack([1 - u - v, u, v], 1).astype(np.float32)
        for part in np.array_split(mine, max(1, len(mine) * len(weights) // 1_000_000)):
            points = (weights @ at[part]).reshape(-1, 3)
            pixel = points[:, 1].astype(np.int32) * width + points[:, 0].astype(np.int32)
            triangle = np.repeat(part, len(weights))
            nearer = np.flatnonzero(points[:, 2] > depth[pixel])
            nearer = nearer[np.argsort(points[nearer, 2])]  # of points in a pixel the nearest comes last
            depth[pixel[nearer]], which[pixel[nearer]] = points[nearer, 2], triangle[nearer]
            lit[pixel[nearer]] = (shade[part] @ weights.T).ravel()[nearer]
    image = np.ones((height, width, 4))
    image[..., 3] = 0
    which = which.reshape(height, width)
    there = which >= 0
    image[there, :3] = colours[owner[which[there]], :3] * lit.reshape(height, width)[there][:, None]
    image[there, 3] = 1
    body = np.where(there, owner[which], -1)
    outline = np.zeros_like(there)
    outline[:-1] |= body[:-1] != body[1:]
    outline[:, :-1] |= body[:, :-1] != body[:, 1:]
    image[outline] = (0.15, 0.15, 0.15, 1)
    return image


def coloured(fields):
    """Colour of each grain, and legend entries (or a colour bar's map, norm and name)."""
    ids, first = np.unique(fields["id"].astype(int), return_index=True)
    if "fragment" in fields:
        fragment = fields["fragment"][first].astype(int)
        cells = np.bincount(fragment)
        colours = plt.cm.tab10(fragment % 10)
        colours[cells[fragment] <= cells.max() / 20] = (0.6, 0.6, 0.6, 1)
        return ids, colours, "by fragment (grey: small ones)", None
    generation = fields["generation"][first].astype(int) if "generation" in fields else np.zeros(len(ids), int)
    if generation.max() > 0:
        most = generation.max()
        palette = np.vstack([[0.87, 0.80, 0.66, 1], plt.cm.plasma(np.linspace(0.15, 0.95, most))])
        return ids, palette[generation], "by generation", [
            ("whole grains" if k == 0 else f"broken {k} time{'s' if k > 1 else ''}", palette[k])
            for k in range(most + 1) if (generation == k).any()
        ]
    radius = 1e3 * fields["radius"][first]
    norm = plt.Normalize(radius.min(), radius.max() if np.ptp(radius) > 1e-3 * radius.max() else 1.5 * radius.max())
    return ids, plt.cm.cividis(norm(radius)), "by size", (plt.cm.cividis, norm, "equivalent radius (mm)")


def grains(folder, name):
    """draw(ax) of the grains of the last frame; None where there is none."""
    seen = last_frame(folder, "grains")
    if seen is None:
        return None
    corners, at = seen.triangles()
    if not len(at):
        return None
    triangles, fields = seen.points[corners], {k: v[at] for k, v in seen.cells.items()}
    ids, colours, how, key = coloured(fields)
    owner = np.searchsorted(ids, fields["id"].astype(int))
    size = np.ptp(triangles.reshape(-1, 3), axis=0)
    flat = int(np.argmin(
        size)) if size.min() < 0.25 * np.sort(size)[1] else None  # a plate or a prism is seen along its short side
    turn = {
        None: view(), 0: np.roll(np.eye(3), -1, axis=0), 1: np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), 2: np.eye(3)
    }[flat]
    normals = corner_normals(seen.points.astype(float), corners, "sphericity" not in fields)
    image = painted(triangles.astype(float), normals, owner, colours, turn)

    def draw(ax):
        ax.imshow(image, origin="lower", interpolation="antialiased")
        ax.set_axis_off()
        ax.set_title(f"{name}: {len(ids)} grains in the last frame, {how}")
        if isinstance(key, list):
            for label, colour in key:
                ax.plot([], [], "o", ms=8, color=colour, label=label)
            ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
        elif key is not None:
            ax.figure.colorbar(plt.cm.ScalarMappable(key[1], key[0]), ax=ax, shrink=0.6, label=key[2])
    return draw


def pulled(points, piece, share=0.25):
    """Points of pieces, each moved away from the middle of all by a share of where its own middle lies."""
    middles = np.array([points[piece == k].mean(0) for k in range(piece.max() + 1)])
    return points + share * (middles - points.mean(0))[piece]


def cracked(folder, name, most=4):
    """[draw(ax)] of grains that cracked, one each, `most` of them: their points by damage, cut in halves and seen from
    the cut, and by piece, pulled apart."""
    draws = []
    for path, time in frames(folder, "lattice")[:most]:
        try:
            seen = Frame(path, time)
        except (InputError, ValueError):
            return []
        draws.append(points_of(seen, name))
    return draws


def points_of(seen, name):
    """draw(ax) of one cracked grain."""
    points, damage = seen.points.astype(float), seen.at_points["damage"].astype(float)
    piece = seen.at_points["piece"].astype(int)
    turn = view()
    place = (points - points.mean(0)) @ turn.T
    apart = pulled(place, piece)
    half = np.flatnonzero(place[:, 2] <= 0)
    half = half[np.argsort(place[half, 2])]
    order = np.argsort(apart[:, 2])
    wide = 1.15 * 1e3 * np.ptp(np.vstack([place, apart])[:, 0])
    dots = 2.6e4 / len(points)
    count = np.bincount(piece)

    def draw(ax):
        left = ax.scatter(1e3 * place[half, 0], 1e3 * place[half, 1], c=damage[half], s=dots, cmap="inferno_r", vmin=0,
                          vmax=1, edgecolors="0.4", linewidths=0.2)
        ax.scatter(1e3 * apart[order, 0] + wide, 1e3 * apart[order, 1], c=plt.cm.tab10(piece[order] % 10), s=dots,
                   edgecolors="0.2", linewidths=0.2)
        for k, n in enumerate(count):
            ax.scatter([], [], color=plt.cm.tab10(k % 10), s=40, label=f"piece {k + 1}: {100 * n / len(piece):.3g} %")
        ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.2, 1), frameon=False)
        ax.set_aspect("equal")
        ax.set_axis_off()
        ax.set_title(f"{name}: a grain that cracked at {seen.time:.4g} s, damage and pieces of {len(points)} points")
        ax.figure.colorbar(left, ax=ax, shrink=0.6, label="broken bonds, share")
    return draw


def shear(points, moved, cells):
    """Deviatoric Green-Lagrange strain of each element, sqrt(2/3 E':E'), of the gradient that fits its corners best."""
    found = np.empty(len(cells))
    for k, nodes in enumerate(cells):
        x, u = points[nodes] - points[nodes].mean(0), moved[nodes] - moved[nodes].mean(0)
        gradient = np.linalg.lstsq(x, u, rcond=None)[0].T
        e = 0.5 * (gradient + gradient.T + gradient.T @ gradient)
        e -= np.trace(e) / 3 * np.eye(3)
        found[k] = np.sqrt(2 / 3 * (e * e).sum())
    return found


def outside(cells, types):
    """Faces of one element alone, as (element, corners); in two dimensions the elements themselves."""
    seen = {}
    for k, (nodes, kind) in enumerate(zip(cells, types)):
        for face in FACES.get(int(kind), []):
            corners = [nodes[c] for c in face]
            seen.setdefault(tuple(sorted(corners)), []).append((k, corners))
    return [found[0] for found in seen.values() if len(found) == 1]


def macro(folder, name):
    """[draw(ax)] of the macro mesh, displaced: void ratio, share of broken grains, shear strain."""
    seen = last_frame(folder, "macro")
    if seen is None:
        return []
    points, moved = seen.points.astype(float), seen.at_points["displacement_m"].astype(float)
    cells = [seen.connectivity[a:b] for a, b in zip(seen.offsets[:-1], seen.offsets[1:])]
    faces = outside(cells, seen.types)
    if not faces:
        return []
    deep = np.ptp(points[:, 2]) > 0
    turn = view() if deep else np.eye(3)
    place = (points + moved) @ turn.T
    if deep:  # painter's order; what looks away is hidden
        def towards(corners):
            x = place[corners]
            return np.cross(x[1] - x[0], x[2] - x[0])[2]
        faces = sorted((f for f in faces if towards(f[1]) > 0), key=lambda f: place[f[1], 2].mean())
    owner = np.array([k for k, _ in faces])
    outlines = [1e3 * place[corners, :2] for _, corners in faces]
    fields = {"shear strain": (shear(points, moved, cells), "magma_r")}
    for key, label, colours in (("void_ratio", "void ratio", "viridis"),
                                ("broken_fraction", "broken grains, share", "inferno_r")):
        values = seen.cells.get(key)
        if values is not None and np.isfinite(values).any() and np.nanmax(values) > 0:
            fields[label] = (values, colours)

    def drawn(label, values, colours):
        def draw(ax):
            shown = np.ma.masked_invalid(np.asarray(values, float)[owner])
            painting = PolyCollection(outlines, array=shown, cmap=plt.get_cmap(colours).with_extremes(bad="0.85"),
                                      edgecolors=(0, 0, 0, 0.35), linewidths=0.3)
            ax.add_collection(painting)
            ax.set_aspect("equal")
            ax.autoscale_view()
            if deep:
                ax.set_axis_off()
            else:
                ax.set(xlabel="x (mm)", ylabel="y (mm)")
            ax.set_title(f"{name}: {label} in the last frame, as displaced")
            ax.figure.colorbar(painting, ax=ax, label=label, shrink=0.8)
        return draw
    return [drawn(label, *v) for label, v in fields.items()]
