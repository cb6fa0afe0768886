// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/hull_pairs.hpp"

#include <algorithm>
#include <atomic>

#include "dem/contact/broad_phase.hpp"
#include "dem/shape/separation.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

double depth_of(const Grains& g, Index i) { return g.hulls->row[g.hull[i]].depth; }
HullView hull_of_grain(const Grains& g, Index i) { return (*g.hulls)[g.hull[i]]; }

Vec3 shift_of(const Grains& g, const Cell& cell, Index a, Index b, const std::array<std::int16_t, 3>& image) {
  Vec3 r = g.motion[b].position - g.motion[a].position;
  if ((image[0] | image[1] | image[2]) != 0) r += at_image(cell.vectors, image);
  return r;
}

/// How two hulls move at the middle of their contact, b against a.
struct Meeting {
  Vec3 normal;         // from a to b, as the force on b
  double force;        // its size for a modulus of 1
  Vec3 velocity;       // m/s
  double spin;         // rad/s, about the normal
  double twist;        // of both, the mean (rad/s)
  double mobility[2];  // of a and b at the middle along the normal (1/kg); of a wall 0

  double mass() const { return 1 / (mobility[0] + mobility[1]); }  // effective (kg)
};

/// What a contact does to b: the potential's wrench, and dashpot and friction at the middle of the area.
struct Press {
  Vec3 elastic, rest;  // N
  double moment;       // of rest, along the normal (N m)
};

void apart(Contacts& contacts, std::size_t k, BlockEnergy& e) {
  contacts.active[k] = 0;
  if (!contacts.contact.touching(k)) return;
  Contact c = contacts.contact[k];
  part_contact(c, contacts.touch[k], e);
  contacts.contact.set(k, c);
}

/// Friction is one spring of three components: two along the plane, and one, along the normal, for spin against each
/// other: its arm is the area's radius of gyration, so that the same stiffness and the same limit serve for all three.
Press advance(const TileWork& s, std::size_t k, const Overlap& o, double modulus, const Meeting& m) {
  Contact c = s.contacts.contact[k];
  Touch& touch = s.contacts.touch[k];
  const PairLaw& p = s.pairs[s.contacts.pair[k].law];
  const double force = m.force, area = o.area.norm();
  // Deep in each other the area vector all but closes: no arm is longer than the body.
  const double arm = std::min(std::sqrt(o.polar / area), s.grains.motion[s.contacts.pair[k].a].radius);
  const Vec3 &n = m.normal, before = touch.normal;
  if (c.stiffness == 0) c.radius = modulus;
  c.stiffness = c.radius * area;
  const Elastic elastic{c.radius * force, c.stiffness, c.radius * o.energy, c.stiffness};
  const double vn = m.velocity.dot(n);
  const double viscous = advance_dashpot(p, m.mass(), elastic, vn, s.dt(), c, s.energy);
  Press out{c.radius * o.force, viscous * n, 0};
  if (p.friction[slide_spring] > 0) {
    Vec3& spring = c.spring[slide_spring];
    const double torsion = spring.dot(before);
    const Vec3 along = turned_spring(slide_spring, spring - torsion * before, n, m.twist * s.dt());
    const double kt = p.shear_ratio * c.stiffness;
    advance_spring(spring, c.compliance, along + torsion * n, s.dt() * (m.velocity + (arm * m.spin - vn) * n), kt,
                   p.friction[slide_spring] * (elastic.force + viscous), s.energy);
    c.compliance = 1 / kt;
    const double turning = spring.dot(n);
    out.rest += spring - turning * n, out.moment = arm * turning;
  }
  touch.normal = n, touch.overlap = force / area, touch.held = elastic.energy;
  touch.force = out.elastic + out.rest;
  s.contacts.contact.set(k, c), s.contacts.active[k] = 1;
  return out;
}

/// A contact asks for an estimate once it has become so much stiffer than at the last.
constexpr double firmer_by = 1.25;

/// The eigenvalue that contact k alone, of this weight in the bound of the time step, gives to either: faces that come
/// to lie on each other resist with all their area from one step to the next. It is too large for some, so that the
/// step may bear more of a contact than it allows: each is held to what has been borne of itself, and hides no other.
void watch(Contacts& contacts, std::size_t k, const Meeting& m, const Overlap& o, double weight, double turned) {
  const double shifts = contacts.contact.stiffness[k] * std::max(m.mobility[0], m.mobility[1]);
  const double turns = contacts.contact.radius[k] * o.polar * turned;
  const double alone = weight * sharpness(o.volume, m.force) * std::max(shifts, turns);
  if (alone > std::max(contacts.plan.firmest, firmer_by * contacts.contact.reach[k]))
    std::atomic_ref(contacts.plan.firmer).store(1, std::memory_order_relaxed);
}

/// Their distance; `normal` as the direction of `separation`, global.
double distance_of_pair(const Grains& g, const Cell& cell, const Candidate& pair, Vec3& normal) {
  const Mat3 &axes = g.frame[pair.a].axes, back = axes.transpose();
  Vec3 direction = back * normal;
  const double distance = separation(hull_of_grain(g, pair.a), hull_of_grain(g, pair.b), back * g.frame[pair.b].axes,
                                     back * shift_of(g, cell, pair.a, pair.b, pair.image), direction);
  normal = axes * direction;
  return distance;
}

/// Overlap with a wall, global; `to`: from the mass centre of hull i to the wall's point. Scenes refuse hulls at walls
/// that have no overload here.
Overlap overlap_at(const auto&, const Grains&, Index, const Vec3&) { return {}; }

Overlap overlap_at(const PlaneWall& wall, const Grains& g, Index i, const Vec3& to) {
  const Mat3& axes = g.frame[i].axes;
  const Plane plane{axes.transpose() * wall.normal, wall.normal.dot(to)};
  return turned(overlap_with_plane(hull_of_grain(g, i), plane, g.motion[i].radius), axes);
}

Overlap overlap_at(const RollerWall& wall, const Grains& g, Index i, const Vec3& to) {
  const Vec3 across = to - wall.axis.dot(to) * wall.axis;
  return overlap_of(hull_of_grain(g, i), (*g.hulls)[wall.hull], g.frame[i].axes, Mat3::Identity(), to,
                    across.normalized());
}

/// Asks for what the kernel reads of a hull, which lies anywhere: its planes in columns, its corners in rows.
void fetch(const HullView& hull) {
  const double *const planes = hull.column + 3 * hull.room, *const corners = hull.rows + 4 * hull.space;
  for (int k = 0; k < 4 * hull.space; k += 8) __builtin_prefetch(planes + k);
  for (int k = 0; k < 4 * hull.vertices; k += 8) __builtin_prefetch(corners + k);
}

}  // namespace

bool presses(const Overlap& o) { return o.volume > 0 && o.force.squaredNorm() > 0 && o.area.squaredNorm() > 0; }

double mobility(const Grains& g, Index i, const Vec3& arm, const Vec3& n) {
  const Motion& m = g.motion[i];
  if (!(m.inverse_inertia > 0)) return m.inverse_mass;
  const Vec3 lever = g.frame[i].axes.transpose() * arm.cross(n);  // a hull's own axes are principal
  return m.inverse_mass + lever.cwiseAbs2().dot(g.inertia[i].moments.cwiseInverse());
}

double turned_apart(const Grains& g, Index i) { return g.turn_mass.empty() ? 0 : 1 / g.inertia[i].moments.minCoeff(); }

double sharpness(double volume, double force) { return std::max(1.0, force / volume); }

double foundation_of(const PairLaw& p, const Grains& g, Index a, Index b) {
  return own<Foundation>(p).over(depth_of(g, a) + depth_of(g, b));
}

double foundation_of(const PairLaw& p, const Grains& g, Index a) { return own<Foundation>(p).over(depth_of(g, a)); }

Overlap overlap_of_pair(const Grains& g, const Cell& cell, const Pair& pair, const Vec3& search, HullGuess* guess) {
  return overlap_of(hull_of_grain(g, pair.a), hull_of_grain(g, pair.b), g.frame[pair.a].axes, g.frame[pair.b].axes,
                    shift_of(g, cell, pair.a, pair.b, pair.image), search, guess);
}

Overlap overlap_if_pressed(const Grains& g, const Cell& cell, const Pair& pair, const Vec3& normal, double reach,
                           double press) {
  const HullView a = hull_of_grain(g, pair.a), b = hull_of_grain(g, pair.b);
  const Mat3 &axes = g.frame[pair.a].axes, &other = g.frame[pair.b].axes, back = axes.transpose();
  const Vec3 shift = shift_of(g, cell, pair.a, pair.b, pair.image);
  const double gap = separation_along(a, b, back * other, back * shift, back * normal);
  if (gap > reach + press) return {};
  return overlap_of(a, b, axes, other, shift - (std::max(gap, 0.0) + press) * normal, normal);
}

Overlap overlap_at_wall(const Grains& g, const Wall& wall, Index i) {
  const Vec3 to = wall.point - g.motion[i].position;
  return std::visit([&](const auto& shape) { return overlap_at(shape, g, i, to); }, wall.shape);
}

void hulls(const TileWork& s, std::size_t begin, std::size_t end) {
  Contacts& contacts = s.contacts;
  const Grains& g = s.grains;
  const Cell& cell = s.boundary.cell;
  const std::size_t first = contacts.begin[hull_hull];
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    if (s.sleep && s.sleep->asleep(k - first, pair.a, pair.b)) continue;
    if (k + 1 < end) fetch(hull_of_grain(g, contacts.pair[k + 1].b));
    const Motion &a = g.motion[pair.a], &b = g.motion[pair.b];
    Vec3& search = contacts.touch[k].normal;
    const Vec3 shift = shift_of(g, cell, pair.a, pair.b, pair.image);
    HullGuesses::Row& known = contacts.guesses.row[k - first];
    if (known.a != g.hull[pair.a] || known.b != g.hull[pair.b])
      known.a = g.hull[pair.a], known.b = g.hull[pair.b], known.guess.octets = 0;
    const Overlap o = overlap_of(hull_of_grain(g, pair.a), hull_of_grain(g, pair.b), g.frame[pair.a].axes,
                                 g.frame[pair.b].axes, shift, search, &known.guess);
    if (!presses(o)) {
      // The direction that parts them is far cheaper to find out by in the next step.
      if (!o.parted)
        distance_of_pair(g, cell, {pair.a, pair.b, pair.image}, search);
      else if (s.sleep)
        s.sleep->rest(k - first, pair.a, pair.b, o.gap);
      apart(contacts, k, s.energy);
      continue;
    }
    const Vec3 arm_b = o.middle - shift;
    Vec3 drag = Vec3::Zero();
    if (crosses(pair)) drag = at_image(cell.rate, pair.image);
    const double size = o.force.norm();
    const Vec3 n = o.force / size;
    const Meeting m{n,
                    size,
                    b.velocity + b.spin.cross(arm_b) + drag - a.velocity - a.spin.cross(o.middle),
                    n.dot(b.spin - a.spin),
                    0.5 * n.dot(a.spin + b.spin),
                    {mobility(g, pair.a, o.middle, n), mobility(g, pair.b, arm_b, n)}};
    const double modulus =
        contacts.contact.touching(k) ? contacts.contact.radius[k] : foundation_of(s.pairs[pair.law], g, pair.a, pair.b);
    const Press press = advance(s, k, o, modulus, m);
    watch(contacts, k, m, o, 2, std::max(turned_apart(g, pair.a), turned_apart(g, pair.b)));
    const Vec3 force = press.elastic + press.rest;
    const Vec3 moment = contacts.contact.radius[k] * o.moment + press.moment * n;  // about the mass centre of a
    if (contacts.spots) contacts.spot[k] = {o.middle, moment - o.middle.cross(press.elastic)};
    Load& of_a = s.load[pair.a - s.first];
    of_a.force -= force, of_a.torque -= moment + o.middle.cross(press.rest);
    const Index target = contacts.plan.target[k];
    Load& of_b = target < g.size() ? s.load[target - s.first] : contacts.plan.load[target];
    of_b.force += force, of_b.torque += moment - shift.cross(press.elastic) + arm_b.cross(press.rest);
    s.energy.work -= s.dt() * force.dot(drag);
  }
}

void hulls_at_walls(const TileWork& s, std::size_t begin, std::size_t end) {
  Contacts& contacts = s.contacts;
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    const Motion& a = s.grains.motion[pair.a];
    const Wall& wall = s.boundary.walls[pair.b];
    const Overlap o = overlap_at_wall(s.grains, wall, pair.a);
    if (!presses(o)) {
      apart(contacts, k, s.energy);
      continue;
    }
    const double size = o.force.norm();
    const Vec3 n = o.force / size;
    const Meeting m{n,
                    size,
                    wall.velocity - a.velocity - a.spin.cross(o.middle),
                    -n.dot(a.spin),
                    0.5 * n.dot(a.spin),
                    {mobility(s.grains, pair.a, o.middle, n), 0}};
    const Press press = advance(s, k, o, foundation_of(s.pairs[pair.law], s.grains, pair.a), m);
    watch(contacts, k, m, o, 1, turned_apart(s.grains, pair.a));
    const Vec3 force = press.elastic + press.rest;
    const Vec3 moment = contacts.contact.radius[k] * o.moment + press.moment * n;
    if (contacts.spots) contacts.spot[k] = {o.middle, moment - o.middle.cross(press.elastic)};
    Load& of_a = s.load[pair.a - s.first];
    of_a.force -= force, of_a.torque -= moment + o.middle.cross(press.rest);
    s.energy.work -= s.dt() * force.dot(wall.velocity);
  }
}

bool hulls_near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, Vec3& normal) {
  const Mat3 &axes = g.frame[pair.a].axes, back = axes.transpose(), turn = back * g.frame[pair.b].axes;
  const HullView a = hull_of_grain(g, pair.a), b = hull_of_grain(g, pair.b);
  const Vec3 shift = back * shift_of(g, cell, pair.a, pair.b, pair.image);
  if (normal != Vec3::Zero() && separation_along(a, b, turn, shift, back * normal) > skin) return false;
  Vec3 direction = back * normal;
  double gap = separation(a, b, turn, shift, direction);
  if (!(gap > 0)) gap = face_separation(a, b, turn, shift, direction);  // they meet: along what they are least deep
  normal = axes * direction;
  return gap <= skin;
}

}  // namespace grus::dem
