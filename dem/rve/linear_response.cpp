// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/linear_response.hpp"

#include "dem/bond/kinds.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/rve/block_cholesky.hpp"
#include "dem/rve/measure.hpp"

namespace grus::dem {
namespace {

using Link = LinearResponse::Link;
using Strain = Eigen::Matrix<double, 3, 6>;
using Freedom = Eigen::Matrix<double, 3, 6>;  // of one grain: what translation and rotation do to a contact point

Freedom freedom(const Vec3& arm) {
  Freedom f;
  f.leftCols<3>().setIdentity();
  f.rightCols<3>() = -cross_matrix(arm);  // omega x arm
  return f;
}

/// A grain under the load that a strain would bring, as the criteria see it.
struct Foretold {
  const LinearResponse::Grain& grain;
  const std::vector<Link>& links;
  const std::vector<double>& force;  // of the links, under the strain (N)
  const Vec6& strain;

  Mat3 stress() const {
    Mat3 loaded = grain.stress;
    for (int v = 0; v < 6; ++v) loaded += strain[v] * grain.change[static_cast<std::size_t>(v)];
    return loaded;
  }
  double poissons_ratio() const { return grain.poissons_ratio; }
  double radius() const { return grain.radius; }
  Vec3 arm(Index at) const { return grain.contact[at].arm; }

  /// Hertz: the contact's radius goes with the cube root of the force.
  template <class F>
  void each_contact(F&& f) const {
    for (std::size_t e = 0; e < grain.contact.size(); ++e) {
      const auto& c = grain.contact[e];
      const double now = force[c.link];
      if (now > 0) f(now, c.radius * std::cbrt(now / std::max(links[c.link].force, 1e-300)), static_cast<Index>(e));
    }
  }
};

/// What holds two grains together: a contact or a bond.
struct Spring {
  Index a, b;
  Freedom of_a, of_b;        // what the grains' motion does to the opening
  Strain of_strain;          // what a strain does to it
  Mat3 stiffness;            // N/m
  Mat3 turn = Mat3::Zero();  // N m, of face bonds and couples' springs: against turns of b and a

  Strain opening(const Eigen::MatrixXd& moved) const {
    return of_strain + of_b * moved.middleRows<6>(static_cast<Eigen::Index>(6 * b)) +
           of_a * moved.middleRows<6>(static_cast<Eigen::Index>(6 * a));
  }
  /// How b turns against a (rad).
  Strain turning(const Eigen::MatrixXd& moved) const {
    return moved.middleRows<3>(static_cast<Eigen::Index>(6 * b + 3)) -
           moved.middleRows<3>(static_cast<Eigen::Index>(6 * a + 3));
  }
};

Spring spring_between(const State& s, std::size_t k, const Mat3& stiffness) {
  const Pair& p = s.contacts.pair[k];
  return {p.a,
          p.b,
          -freedom(contact_arm(s.grains, s.contacts, k, false)),
          freedom(contact_arm(s.grains, s.contacts, k, true)),
          displacement_of_strain(branch(s, k)),
          stiffness};
}

/// A sample as springs: one for each of the response's links, in their order, then the bonds.
struct Network {
  std::vector<Spring> spring;
  std::array<std::vector<Mat3>, spring_rows> couple;  // N: of the links' springs, by turn of b against a
  std::vector<std::size_t> link;                      // of each pair; SIZE_MAX: does not touch
  double sliding = 0;                                 // N, normal forces of contacts at Coulomb's limit
  double stiffest = 0;                                // N/m
};

/// `all_slip`: what is at Coulomb's limit gives way along the plane of contact, a couple at its own limit gives way.
Network network_of(const Model& model, const State& s, bool all_slip, LinearResponse& out) {
  Network net;
  net.link.assign(s.contacts.size(), SIZE_MAX);
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    const Contact c = s.contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const Touch& touch = s.contacts.touch[k];
    const PairLaw& law = model.pairs[s.contacts.pair[k].law];
    const Elastic elastic = elastic_response(model.law, s.contacts, k);
    const double borne = elastic.bears(elastic.force);
    const bool slides = law.friction[slide_spring] > 0 &&
                        c.spring[slide_spring].norm() >= law.friction[slide_spring] * borne * (1 - 1e-6);
    if (slides) net.sliding += std::abs(elastic.force);
    const double kt = law.friction[slide_spring] > 0 && !(slides && all_slip) ? law.shear_ratio * elastic.grip : 0;
    net.link[k] = out.links.size();
    const Mat3 along = touch.normal * touch.normal.transpose();
    net.spring.push_back(spring_between(s, k, (elastic.normal_stiffness - kt) * along + kt * Mat3::Identity()));
    for (const SpringRow row : couple_springs) {
      if (!s.contacts.contact.keeps[row]) continue;
      const double limit = law.friction[row] * borne;
      const bool gives = law.friction[row] == 0 || (all_slip && c.spring[row].norm() >= limit * (1 - 1e-6));
      const double held = gives ? 0 : law.shear_ratio * elastic.grip * c.radius;  // force by turn (N)
      const Mat3 own = own_turn(row, touch.normal);
      net.spring.back().turn += held * c.radius * own;
      net.couple[row].push_back(held * own);
      out.couples[row].push_back({c.spring[row], law.friction[row], {}});
    }
    net.stiffest = std::max(net.stiffest, elastic.normal_stiffness);
    out.links.push_back({touch.normal, c.spring[slide_spring], elastic.force, law.friction[slide_spring], {}});
    out.total_force += std::abs(elastic.force);
  }
  for_each_bond(s.bonds, [&](const auto& bond) {
    const auto& e = bond.ends;
    const Quat &qa = s.grains.orientation[e.a], &qb = s.grains.orientation[e.b];
    const BondFrame at = frame_of(s.grains, s.boundary.cell, e);
    const BondStiffness held = stiffness(bond, at, {&s.grains});
    net.spring.push_back({e.a, e.b, -freedom(qa * bond.at_a), freedom(qb * bond.at_b),
                          displacement_of_strain(branch(s.grains, s.boundary.cell, e)), held.shift, held.turn});
    net.stiffest = std::max(net.stiffest, held.shift.trace());
  });
  return net;
}

/// What the grains do for each unit strain, at rest; false where nothing holds them.
bool relax(const State& s, const Network& net, Eigen::MatrixXd& moved) {
  const std::size_t n = s.grains.size();
  std::vector<std::pair<int, int>> pairs;
  for (const Spring& k : net.spring)
    if (k.a != k.b) pairs.emplace_back(static_cast<int>(k.a), static_cast<int>(k.b));
  BlockCholesky matrix(n, pairs);
  moved = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * n), 6);
  for (const Spring& k : net.spring)
    for (const auto& [i, f] : {std::pair{k.a, k.of_a}, std::pair{k.b, k.of_b}}) {
      moved.middleRows<6>(static_cast<Eigen::Index>(6 * i)) -= f.transpose() * k.stiffness * k.of_strain;
      for (const auto& [j, g] : {std::pair{k.a, k.of_a}, std::pair{k.b, k.of_b}})
        if (i >= j) {
          Mat6 block = f.transpose() * k.stiffness * g;
          block.bottomRightCorner<3, 3>() += i == j ? k.turn : Mat3(-k.turn);
          matrix.add(static_cast<int>(i), static_cast<int>(j), block);
        }
    }
  const double size2 = std::pow(mean_diameter(s.grains), 2);
  Vec6 hold = Vec6::Constant(1e-9 * net.stiffest);  // what nothing else holds: the whole, and grains without contacts
  hold.tail<3>() *= size2;
  for (std::size_t i = 0; i < n; ++i) matrix.add(static_cast<int>(i), static_cast<int>(i), hold.asDiagonal());
  if (!matrix.factorise()) return false;
  matrix.solve(moved);
  return true;
}

/// The grains that can break, with what a strain does to their stress.
void add_grains(const Model& model, const State& s, const Network& net, LinearResponse& out) {
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const Material& material = model.materials[s.grains.material[i]];
    if (!material.fracture) continue;
    LinearResponse::Grain grain;
    grain.material = s.grains.material[i], grain.strength = s.grains.strength[i];
    grain.poissons_ratio = material.poissons_ratio, grain.radius = s.grains.extent[i].equivalent_radius;
    grain.stress = grain_stress(s.grains, s.contacts, i);
    grain.change.fill(Mat3::Zero());
    for (Index e = s.contacts.index.first[i]; e < s.contacts.index.first[i + 1]; ++e) {
      const std::size_t k = s.contacts.index.entry[e] >> 1;
      if (net.link[k] == SIZE_MAX) continue;
      const bool is_b = s.contacts.index.entry[e] & 1;
      const Vec3 arm = contact_arm(s.grains, s.contacts, k, is_b);
      for (int v = 0; v < 6; ++v) {
        const Vec3 change = out.links[net.link[k]].change.col(v);
        const Mat3 part = (is_b ? 1.0 : -1.0) * change * arm.transpose() / s.grains.extent[i].volume;
        grain.change[static_cast<std::size_t>(v)] += 0.5 * (part + part.transpose());
      }
      const double radius = std::sqrt(s.contacts.contact[k].radius * s.contacts.touch[k].overlap);
      grain.contact.push_back({net.link[k], radius, arm});
    }
    out.grains.push_back(std::move(grain));
  }
}

/// `share` not finite: whatever slides gives way, and only the tangent is made.
std::unique_ptr<const LinearResponse> respond(const Model& model, const State& s, double share) {
  const bool tangent_only = !std::isfinite(share);
  auto out = std::make_unique<LinearResponse>();
  const double volume = s.boundary.cell.volume();
  const Network net = network_of(model, s, tangent_only, *out);
  if (net.spring.empty() || net.sliding > share * out->total_force) return nullptr;
  Eigen::MatrixXd moved;
  if (!relax(s, net, moved)) return nullptr;
  out->stress = love_weber(s, volume);
  for (std::size_t n = 0; n < net.spring.size(); ++n) {
    const Spring& spring = net.spring[n];
    const Strain pull = spring.stiffness * spring.opening(moved);  // force that b exerts when it moves away from a
    if (n < out->links.size()) out->links[n].change = -pull;
    for (const SpringRow row : couple_springs)
      if (n < net.couple[row].size()) out->couples[row][n].change = -net.couple[row][n] * spring.turning(moved);
    out->tangent += spring.of_strain.transpose() * pull / volume;
  }
  out->tangent = Mat6(0.5 * (out->tangent + out->tangent.transpose()));
  if (tangent_only) return out;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k)
    if (net.link[k] == SIZE_MAX) {
      const Touch& t = s.contacts.touch[k];
      out->gaps.push_back({-t.overlap, spring_between(s, k, Mat3::Zero()).opening(moved).transpose() * t.normal});
    }
  if (model.breakable()) add_grains(model, s, net, *out);
  return out;
}

}  // namespace

std::unique_ptr<const LinearResponse> linear_response(const Model& model, const State& state, double share) {
  if (state.bonds.size() > 0 || !state.boundary.cell.periodic() || attracts(model.law)) return nullptr;
  return respond(model, state, share);
}

Mat6 network_tangent(const Model& model, const State& state) {
  const auto r = respond(model, state, INFINITY);
  return r ? r->tangent : Mat6(Mat6::Zero());
}

bool LinearResponse::holds(const Model& model, const Vec6& strain, double share) const {
  const double limit = share * total_force;
  double outside = 0, changed = 0;
  std::vector<double> force(links.size());
  for (std::size_t k = 0; k < links.size(); ++k) {
    const Link& l = links[k];
    const Vec3 change = l.change * strain;
    const double along = change.dot(l.normal), now = force[k] = l.force + along;
    changed += std::abs(along);
    const bool slides = l.friction > 0 && (l.spring + change - along * l.normal).norm() > l.friction * now;
    const bool gives = std::any_of(couples.begin(), couples.end(), [&](const std::vector<Couple>& of) {
      return !of.empty() && of[k].friction > 0 && (of[k].spring + of[k].change * strain).norm() > of[k].friction * now;
    });
    if (now <= 0 || slides || gives) outside += std::max(l.force, now);
    if (outside > limit) return false;
  }
  if (changed > 0.1 * total_force) return false;
  for (const Gap& g : gaps)
    if (g.width + g.change.dot(strain) < 0) {  // a contact that would close would carry about what the mean one does
      outside += total_force / static_cast<double>(links.size());
      if (outside > limit) return false;
    }
  for (const Grain& g : grains)
    if (judge(model.materials[g.material].fracture->criteria, Foretold{g, links, force, strain}, g.strength)
            .utilisation >= 1)
      return false;
  return true;
}

}  // namespace grus::dem
