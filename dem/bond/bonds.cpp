// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/bonds.hpp"

#include <algorithm>

#include "dem/bond/dashpots.hpp"
#include "dem/bond/kinds.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

/// Fewer bonds are one thread's work: to call the others costs more.
constexpr std::size_t few = 200;

void clear(Grains& g, std::size_t i) { g.force[i].setZero(), g.torque[i].setZero(); }

bool crosses(const BondEnds& e) { return (e.image[0] | e.image[1] | e.image[2]) != 0; }

template <class Row>
void deal(std::size_t grains, BondColumn<Row>& column) {
  BondTiles& t = column.tiles;
  const std::size_t tiles = tile_count(grains);
  const int bits = tile_bits(grains);
  t.grains = grains;
  t.first.assign(tiles + 1, 0), t.first_far = t.first;
  t.bond.clear(), t.bond_far.clear();
  t.dissipated.resize(tiles), t.rubbed.resize(tiles), t.power.resize(tiles), t.viscous.resize(tiles);
  t.broken.resize(tiles), t.begun.resize(tiles);
  t.far.resize(column.row.size());
  const auto lower = [&](const Row& r) { return std::min(r.ends.a, r.ends.b) >> bits; };
  const auto higher = [&](const Row& r) { return std::max(r.ends.a, r.ends.b) >> bits; };
  const auto collect = [&](auto&& tile_of, std::vector<Index>& first, std::vector<Index>& bond, auto&& taken) {
    for (const Row& r : column.row)
      if (taken(r)) ++first[tile_of(r) + 1];
    for (std::size_t k = 0; k < tiles; ++k) first[k + 1] += first[k];
    bond.resize(first[tiles]);
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (std::size_t k = 0; k < column.row.size(); ++k)
      if (taken(column.row[k])) bond[next[tile_of(column.row[k])]++] = static_cast<Index>(k);
  };
  collect(lower, t.first, t.bond, [](const Row&) { return true; });
  collect(higher, t.first_far, t.bond_far, [&](const Row& r) { return lower(r) != higher(r); });
}

/// The bond's force now; what it takes for that is added to `spent` and, by friction, to `rubbed` (J).
template <class Row>
Pull go_on(const Grains& g, const Cell& cell, Row& row, const FaceOutline& outline, double& spent, double& rub) {
  const double before = dissipated(row), rubbed_before = rubbed(row);
  Pull p = pull(row, frame_of(g, cell, row.ends), outline);
  spent += dissipated(row) - before, rub += rubbed(row) - rubbed_before;
  return p;
}

/// Books what bonds of one kind have taken: what they give back is not made good by what others take.
void book_fracture(double taken, Ledger& ledger) {
  ledger.fracture += taken, ledger.most_fracture += std::max(taken, 0.0);
}

bool wants_outline(const CohesiveSpring&, const FaceOutline&) { return false; }
bool wants_outline(const FaceBond& row, const FaceOutline& outline) {
  return row.onset > 0 && !broken(row) && outline.kept.empty();
}

/// Clears the grains of a tile that this kind's bonds write to.
template <class Row>
void clear_tile(Grains& g, const BondColumn<Row>& column, std::size_t tile) {
  const BondTiles& t = column.tiles;
  for (Index n = t.first[tile]; n < t.first[tile + 1]; ++n) {
    const BondEnds& e = column.row[t.bond[n]].ends;
    for (const Index i : {e.a, e.b})
      if (i >> tile_bits(g.size()) == tile) clear(g, i);
  }
  for (Index n = t.first_far[tile]; n < t.first_far[tile + 1]; ++n) {
    const BondEnds& e = column.row[t.bond_far[n]].ends;
    clear(g, std::max(e.a, e.b));
  }
}

/// Dashpots by the rows of their kind, and the time since they were last asked.
struct Dashpots {
  std::span<FaceDashpot> of;
  double dt;

  template <class Row>
  double resist(const Grains& g, const Cell& cell, Row& row, Index k, Pull& p) const {
    if constexpr (std::is_same_v<Row, FaceBond>)
      if (!of.empty()) return dem::resist(g, cell, row, of[k], dt, p);
    return 0;
  }
};

/// One tile's bonds: what is felt in the tile goes to the grains, what is felt elsewhere to `far`.
template <class Row>
void pull_tile(Grains& g, const Cell& cell, BondColumn<Row>& column, const FaceOutlines& outlines,
               const Dashpots& dashpots, std::size_t tile) {
  BondTiles& t = column.tiles;
  t.dissipated[tile] = 0, t.rubbed[tile] = 0, t.broken[tile] = 0, t.power[tile] = 0, t.viscous[tile] = 0;
  t.begun[tile] = 0;
  for (Index n = t.first[tile]; n < t.first[tile + 1]; ++n) {
    Row& row = column.row[t.bond[n]];
    const FaceOutline outline{&g, outlines[t.bond[n]]};
    Pull p = go_on(g, cell, row, outline, t.dissipated[tile], t.rubbed[tile]);
    t.begun[tile] += wants_outline(row, outline);
    t.viscous[tile] += dashpots.resist(g, cell, row, t.bond[n], p);
    t.broken[tile] += broken(row);
    if (crosses(row.ends)) t.power[tile] -= p.force.dot(drag(cell, row.ends));
    const auto feels = [&](Index i, const Vec3& force, const Vec3& torque) {
      if (i >> tile_bits(g.size()) == tile)
        g.force[i] += force, g.torque[i] += torque;
      else
        t.far[t.bond[n]].force = force, t.far[t.bond[n]].torque = torque;
    };
    feels(row.ends.b, p.force, p.arm_b.cross(p.force) + p.couple);
    feels(row.ends.a, -p.force, -p.arm_a.cross(p.force) - p.couple);
  }
}

/// Nothing of springs: fresh halves overlap as they will.
void hand_over(const Grains&, const Cell&, const BondColumn<CohesiveSpring>&, Bonds&) {}

void drop_dashpots(const BondColumn<CohesiveSpring>&, std::vector<FaceDashpot>&) {}

void keep_outlines(const Grains&, const BondColumn<CohesiveSpring>&, FaceOutlines&) {}

/// Keeps the outlines of faces that have begun to soften in this step.
void keep_outlines(const Grains& g, const BondColumn<FaceBond>& column, FaceOutlines& outlines) {
  const BondTiles& t = column.tiles;
  outlines.of.resize(column.row.size());
  for (std::size_t tile = 0; tile < t.begun.size(); ++tile)
    for (Index n = t.first[tile]; t.begun[tile] > 0 && n < t.first[tile + 1]; ++n) {
      const Index k = t.bond[n];
      if (!wants_outline(column.row[k], {&g, outlines[k]})) continue;
      const FlatPolygon p = outline_of(g, column.row[k]);
      outlines.of[k] = {static_cast<Index>(outlines.corner.size()), static_cast<Index>(p.corners)};
      outlines.corner.insert(outlines.corner.end(), p.corner.begin(), p.corner.begin() + p.corners);
    }
}

void drop_outlines(const BondColumn<CohesiveSpring>&, FaceOutlines&) {}

/// Drops the outlines of bonds that are about to go.
void drop_outlines(const BondColumn<FaceBond>& column, FaceOutlines& outlines) {
  if (outlines.of.empty()) return;
  outlines.of.resize(column.row.size());
  FaceOutlines left;
  for (std::size_t k = 0; k < column.row.size(); ++k) {
    if (broken(column.row[k])) continue;
    const std::span<const Eigen::Vector2d> corner = outlines[k];
    left.of.push_back({static_cast<Index>(left.corner.size()), static_cast<Index>(corner.size())});
    left.corner.insert(left.corner.end(), corner.begin(), corner.end());
  }
  outlines = std::move(left);
}

/// Those of bonds that are about to go.
void drop_dashpots(const BondColumn<FaceBond>& column, std::vector<FaceDashpot>& dashpot) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < dashpot.size(); ++k)
    if (!broken(column.row[k])) dashpot[kept++] = dashpot[k];
  dashpot.resize(kept);
}

/// By birth, so that nothing depends on threads.
void hand_over(const Grains& g, const Cell& cell, const BondColumn<FaceBond>& column, Bonds& bonds) {
  for (std::size_t k = 0; k < column.row.size(); ++k) {
    const FaceBond& s = column.row[k];
    if (broken(s)) bonds.handed.push_back(handed_by(s, frame_of(g, cell, s.ends), {&g, bonds.outline[k]}));
  }
}

template <class Row>
void collect_far(Grains& g, const BondColumn<Row>& column, std::size_t tile) {
  const BondTiles& t = column.tiles;
  for (Index n = t.first_far[tile]; n < t.first_far[tile + 1]; ++n) {
    const BondEnds& e = column.row[t.bond_far[n]].ends;
    const Index i = std::max(e.a, e.b);
    g.force[i] += t.far[t.bond_far[n]].force, g.torque[i] += t.far[t.bond_far[n]].torque;
  }
}

}  // namespace

Vec3 drag(const Cell& cell, const BondEnds& e) { return at_image(cell.rate, e.image); }

Vec3 branch(const Grains& g, const Cell& cell, const BondEnds& e) {
  const BondFrame at = frame_of(g, cell, e);
  return at.x_b - at.x_a;
}

BondFrame frame_of(const Grains& g, const Cell& cell, const BondEnds& e) {
  BondFrame at{g.orientation[e.a], g.orientation[e.b], g.motion[e.a].position, g.motion[e.b].position};
  if (crosses(e)) at.x_b += at_image(cell.vectors, e.image);
  return at;
}

double bond_forces(Grains& g, const Cell& cell, Bonds& bonds, Ledger& ledger, Team& team, bool again, double dt) {
  const std::size_t n = g.size(), tiles = tile_count(n);
  for_each_kind(bonds, [&](auto& column) {
    if (column.tiles.grains == n && column.tiles.far.size() == column.row.size()) return;
    deal(n, column);
    again = false;  // a bond that has gone since may have left a force where none is now
  });
  const auto over_tiles = [&](auto&& work) {
    if (bonds.size() < few) {
      for (std::size_t t = 0; t < tiles; ++t) work(t);
      return;
    }
    team.pieces(tiles, [&](std::size_t first, std::size_t last, int) {
      for (std::size_t t = first; t < last; ++t) work(t);
    });
  };
  const Dashpots dashpots{bonds.dashpot, dt};
  over_tiles([&](std::size_t t) {
    if (again)
      for_each_kind(bonds, [&](auto& column) { clear_tile(g, column, t); });
    else
      for (std::size_t i = t * tile_size(n); i < std::min(n, (t + 1) * tile_size(n)); ++i) clear(g, i);
    for_each_kind(bonds, [&](auto& column) { pull_tile(g, cell, column, bonds.outline, dashpots, t); });
  });
  over_tiles([&](std::size_t t) { for_each_kind(bonds, [&](auto& column) { collect_far(g, column, t); }); });
  double power = 0;
  for_each_kind(bonds, [&](auto& column) {
    std::size_t gone = 0, begun = 0;
    for (std::size_t t = 0; t < tiles; ++t) {
      book_fracture(column.tiles.dissipated[t], ledger);
      gone += column.tiles.broken[t];
      ledger.friction += column.tiles.rubbed[t], ledger.bond_friction += column.tiles.rubbed[t];
      begun += column.tiles.begun[t];
      power += column.tiles.power[t];
      ledger.damping += column.tiles.viscous[t], ledger.bond_damping += column.tiles.viscous[t];
    }
    if (begun > 0) keep_outlines(g, column, bonds.outline);
    if (gone == 0) return;
    ledger.bonds_broken += gone;
    hand_over(g, cell, column, bonds);
    drop_dashpots(column, bonds.dashpot);
    drop_outlines(column, bonds.outline);
    std::erase_if(column.row, [](const auto& row) { return broken(row); });
    column.tiles.grains = 0;
  });
  return power;
}

double cell_power(const Cell& cell, const Bonds& bonds) {
  double power = 0;
  if (!cell.periodic() || cell.rate.isZero(0)) return power;
  for_each_bond(bonds, [&](const auto& row) {
    if (crosses(row.ends)) power -= row.force.dot(drag(cell, row.ends));
  });
  return power;
}

void add_bond_forces(Grains& g, const Cell& cell, Bonds& bonds, std::span<const std::size_t> before, Ledger& ledger) {
  std::size_t kind = 0;
  for_each_kind(bonds, [&](auto& column) {
    for (std::size_t k = before[kind]; k < column.row.size(); ++k) {
      auto& row = column.row[k];
      double taken = 0, rub = 0;
      const Pull p = go_on(g, cell, row, {&g}, taken, rub);
      book_fracture(taken, ledger);
      ledger.friction += rub, ledger.bond_friction += rub;
      g.force[row.ends.b] += p.force, g.torque[row.ends.b] += p.arm_b.cross(p.force) + p.couple;
      g.force[row.ends.a] -= p.force, g.torque[row.ends.a] -= p.arm_a.cross(p.force) + p.couple;
    }
    column.tiles.grains = 0;
    ++kind;
  });
}

std::vector<std::size_t> counts(const Bonds& bonds) {
  std::vector<std::size_t> n;
  for_each_kind(bonds, [&](const auto& column) { n.push_back(column.row.size()); });
  return n;
}

void renumber(Bonds& bonds, std::span<const Index> place) {
  for_each_kind(bonds, [&](auto& column) {
    for (auto& row : column.row) row.ends.a = place[row.ends.a], row.ends.b = place[row.ends.b];
    column.tiles.grains = 0;
  });
  for (FaceBond& row : bonds.wall) row.ends.a = place[row.ends.a];
  for (DeadLoad& load : bonds.load) load.grain = place[load.grain];
  for (Handed& h : bonds.handed) h.ends.a = place[h.ends.a], h.ends.b = place[h.ends.b];
}

double stored_energy(const Bonds& bonds) {
  double sum = 0;
  for_each_bond(bonds, [&](const auto& row) { sum += energy(row); });
  for (const FaceBond& row : bonds.wall) sum += energy(row);
  for (const Handed& h : bonds.handed) sum += h.kept;
  return sum;
}

}  // namespace grus::dem
