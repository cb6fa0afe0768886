// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/polyellipsoid_pairs.hpp"

#include <algorithm>

#include "dem/contact/broad_phase.hpp"
#include "dem/shape/common_normal.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

inline void apart(Contacts& contacts, std::size_t k, BlockEnergy& e) {
  if (!contacts.contact.touching(k)) return;
  Contact c = contacts.contact[k];
  part_contact(c, contacts.touch[k], e);
  contacts.contact.set(k, c);
}

/// The curvature at a sharp place says little of how the grain gives way there.
double clamped(double radius, double volume_radius) {
  return std::clamp(radius, 0.1 * volume_radius, 4 * volume_radius);
}

/// One pair of shapes, whatever has become of it; see ContactRows::solve.
bool solve_pair(const void* context, std::size_t k, double* found_row) {
  const TileWork& s = *static_cast<const TileWork*>(context);
  Contacts& contacts = s.contacts;
  BlockEnergy& e = s.energy;
  const Pair& pair = contacts.pair[k];
  const bool fresh_contact = !contacts.contact.touching(k);
  Touch& touch = contacts.touch[k];
  const Frame &fa = s.grains.frame[pair.a], &fb = s.grains.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (s.boundary.cell.periodic() && crosses(pair)) r += at_image(s.boundary.cell.vectors, pair.image);
  const ShapePair shapes{s.grains.shape[pair.a], s.grains.shape[pair.b], fa.axes.transpose() * fb.axes,
                         fa.axes.transpose() * r};
  CommonNormal found = warm_common_normal(shapes, fa.axes.transpose() * touch.normal);
  if (fresh_contact &&
      found.overlap > 0) {  // a new contact is checked from scratch: a trap of the warm start shows here
    const CommonNormal fresh = cold_common_normal(shapes);
    if (fresh.overlap < found.overlap) found = fresh;
  }
  const Vec3 n = fa.axes * found.normal;
  touch.normal = n;
  contacts.active[k] = found.overlap > 0;
  if (!(found.overlap > 0)) {
    apart(contacts, k, e);
    return false;
  }
  if (fresh_contact) {
    const ContactCurvature curvature = contact_curvature(shapes, found.normal);
    const double ra = s.grains.extent[pair.a].equivalent_radius, rb = s.grains.extent[pair.b].equivalent_radius;
    Contact c = contacts.contact[k];
    const double radius = clamped(curvature.radius, ra * rb / (ra + rb));
    const auto born = [&]<class Law>(const Law&) {
      begin_contact<Law>(s.pairs[pair.law], radius, curvature.ellipse_factor, c, e);
    };
    std::visit(born, s.law);
    contacts.contact.set(k, c);
  }
  const Vec3 point = fa.origin + fa.axes * (0.5 * (found.point_a + found.point_b));
  for (int j = 0; j < 3; ++j) found_row[j] = n[j], found_row[4 + j] = point[j];
  found_row[3] = found.overlap;
  return true;
}

/// Pairs [begin, end) with walls, one law.
template <class Law>
void at_walls(const Law& law, const TileWork& s, std::size_t begin, std::size_t end) {
  Contacts& contacts = s.contacts;
  BlockEnergy& e = s.energy;
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    Touch& touch = contacts.touch[k];
    const Motion& a = s.grains.motion[pair.a];
    const Frame& frame = s.grains.frame[pair.a];
    const Wall& wall = s.boundary.walls[pair.b];
    const Vec3 inward = wall.facing(), n = -inward, d = frame.axes.transpose() * n;
    const Vec3 tip = frame.origin + frame.axes * support(s.grains.shape[pair.a], d);
    const double overlap = inward.dot(wall.point - tip);
    if (!(overlap > 0)) {
      apart(contacts, k, e);
      continue;
    }
    const Vec3 arm = tip - 0.5 * overlap * n - a.position;
    const PairLaw& p = s.pairs[pair.law];
    Contact c = contacts.contact[k];
    if (c.stiffness == 0) {
      const ContactCurvature curvature = plane_curvature(s.grains.shape[pair.a], d);
      const double radius = clamped(curvature.radius, s.grains.extent[pair.a].equivalent_radius);
      begin_contact<Law>(p, radius, curvature.ellipse_factor, c, e);
    }
    const Vec3 v = wall.velocity - a.velocity - a.spin.cross(arm);
    const Vec3 force =
        advance_contact(law, p, 1 / a.inverse_mass, c, touch, n, overlap, v, 0.5 * n.dot(a.spin), s.dt(), e, -a.spin);
    contacts.contact.set(k, c);
    Load& mine = s.load[pair.a - s.first];
    mine.force -= force, mine.torque += force.cross(arm) - couple(c);
    e.work -= s.dt() * force.dot(wall.velocity);
  }
}

}  // namespace

void polyellipsoids(const TileWork& work, std::size_t begin, std::size_t end) {
  ContactRows rows = work.rows;
  rows.touch = reinterpret_cast<double*>(work.contacts.touch.data());
  rows.solve = solve_pair, rows.context = &work;
  run_rows(work, rows, polyellipsoid_pairs(), begin, end);
}

void polyellipsoids_at_walls(const TileWork& work, std::size_t begin, std::size_t end) {
  std::visit([&](const auto& law) { at_walls(law, work, begin, end); }, work.law);
}

bool near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, Vec3& normal) {
  const Frame &fa = g.frame[pair.a], &fb = g.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (cell.periodic()) r += at_image(cell.vectors, pair.image);
  const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
  if (normal != Vec3::Zero()) return separation_test(shapes, fa.axes.transpose() * normal) > -skin;
  // Any direction whose separation exceeds the skin settles it: most candidates go here, before the full search.
  const Vec3 line = shapes.r.normalized();
  if (separation_test(shapes, line) < -skin) return false;
  const Vec3 scaled = line.cwiseQuotient(octant_squares(shapes.a, line)).normalized();
  if (separation_test(shapes, scaled) < -skin) return false;
  const CommonNormal found = cold_common_normal(shapes);
  normal = fa.axes * found.normal;
  return !found.converged || found.overlap > -skin;
}

}  // namespace grus::dem
