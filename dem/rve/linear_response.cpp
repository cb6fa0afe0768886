// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/linear_response.hpp"

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

/// `share` not finite: whatever slides gives way, and only the tangent is made.
std::unique_ptr<const LinearResponse> respond(const Model& model, const State& s, double share) {
  const bool tangent_only = !std::isfinite(share);
  auto out = std::make_unique<LinearResponse>();
  const std::size_t n = s.grains.size();
  const double volume = s.boundary.cell.volume();
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k)
    if (s.contacts.contact[k].stiffness > 0 && s.contacts.pair[k].a != s.contacts.pair[k].b)
      pairs.emplace_back(static_cast<int>(s.contacts.pair[k].a), static_cast<int>(s.contacts.pair[k].b));
  BlockCholesky matrix(n, pairs);
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(6 * n), 6);
  std::vector<std::size_t> touching(s.contacts.size(), SIZE_MAX);
  std::vector<Mat3> stiffness;
  double sliding = 0, diagonal = 0;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    const Contact c = s.contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const Touch& touch = s.contacts.touch[k];
    const PairLaw& law = model.pairs[s.contacts.pair[k].law];
    const Elastic elastic = std::visit([&](const auto& l) { return l(c.stiffness, touch.overlap); }, model.law);
    const bool slides = law.friction > 0 && c.spring.norm() >= law.friction * elastic.force * (1 - 1e-6);
    if (slides) sliding += elastic.force;
    const double kt = law.friction > 0 && !(slides && tangent_only) ? law.shear_ratio * elastic.normal_stiffness : 0;
    const Mat3 spring =
        (elastic.normal_stiffness - kt) * touch.normal * touch.normal.transpose() + kt * Mat3::Identity();
    touching[k] = out->links.size();
    stiffness.push_back(spring);
    out->links.push_back({touch.normal, c.spring, elastic.force, law.friction, {}});
    out->total_force += elastic.force;
    const Strain b = displacement_of_strain(branch(s, k));
    const auto &a = s.contacts.pair[k].a, &e = s.contacts.pair[k].b;
    const Freedom fa = -freedom(contact_arm(s.grains, s.contacts, k, false)),
                  fb = freedom(contact_arm(s.grains, s.contacts, k, true));
    for (const auto& [i, f] : {std::pair{a, fa}, std::pair{e, fb}}) {
      load.middleRows<6>(static_cast<Eigen::Index>(6 * i)) -= f.transpose() * spring * b;
      for (const auto& [j, g] : {std::pair{a, fa}, std::pair{e, fb}}) {
        if (i >= j) matrix.add(static_cast<int>(i), static_cast<int>(j), f.transpose() * spring * g);
      }
    }
    diagonal = std::max(diagonal, elastic.normal_stiffness);
  }
  if (out->links.empty() || sliding > share * out->total_force) return nullptr;
  const double size2 = std::pow(mean_diameter(s.grains), 2);
  Vec6 hold = Vec6::Constant(1e-9 * diagonal);  // what nothing else holds: the whole, and grains without contacts
  hold.tail<3>() *= size2;
  for (std::size_t i = 0; i < n; ++i) matrix.add(static_cast<int>(i), static_cast<int>(i), hold.asDiagonal());
  if (!matrix.factorise()) return nullptr;
  matrix.solve(load);
  const Eigen::MatrixXd& moved = load;  // of the grains, for each unit strain

  out->stress = love_weber(s, volume);
  auto slip = [&](std::size_t k) {  // relative displacement of b against a
    const auto &a = s.contacts.pair[k].a, &e = s.contacts.pair[k].b;
    return Strain(
        displacement_of_strain(branch(s, k)) +
        freedom(contact_arm(s.grains, s.contacts, k, true)) * moved.middleRows<6>(static_cast<Eigen::Index>(6 * e)) -
        freedom(contact_arm(s.grains, s.contacts, k, false)) * moved.middleRows<6>(static_cast<Eigen::Index>(6 * a)));
  };
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    const Strain relative = slip(k);
    if (touching[k] == SIZE_MAX) {
      const Touch& t = s.contacts.touch[k];
      out->gaps.push_back({-t.overlap, relative.transpose() * t.normal});
      continue;
    }
    Link& link = out->links[touching[k]];
    const Strain pull = stiffness[touching[k]] * relative;  // force that b exerts when it moves away from a
    link.change = -pull;
    out->tangent += displacement_of_strain(branch(s, k)).transpose() * pull / volume;
  }
  out->tangent = Mat6(0.5 * (out->tangent + out->tangent.transpose()));
  if (tangent_only || !model.breakable()) return out;
  for (std::size_t i = 0; i < n; ++i) {
    const Material& material = model.materials[s.grains.material[i]];
    if (!material.fracture) continue;
    LinearResponse::Grain grain;
    grain.material = s.grains.material[i], grain.strength = s.grains.strength[i];
    grain.poissons_ratio = material.poissons_ratio, grain.stress = grain_stress(s.grains, s.contacts, i);
    grain.change.fill(Mat3::Zero());
    const double solid = s.grains.extent[i].volume;
    for (Index e = s.contacts.first[i]; e < s.contacts.first[i + 1]; ++e) {
      const std::size_t k = s.contacts.entry[e] >> 1;
      if (touching[k] == SIZE_MAX) continue;
      const bool is_b = s.contacts.entry[e] & 1;
      const Link& link = out->links[touching[k]];
      const Vec3 arm = contact_arm(s.grains, s.contacts, k, is_b);
      for (int v = 0; v < 6; ++v) {
        const Mat3 part = (is_b ? 1.0 : -1.0) * Vec3(link.change.col(v)) * arm.transpose() / solid;
        grain.change[static_cast<std::size_t>(v)] += 0.5 * (part + part.transpose());
      }
      const double radius = std::sqrt(s.contacts.contact[k].radius * s.contacts.touch[k].overlap);
      grain.contact.push_back({touching[k], radius, arm});
    }
    out->grains.push_back(std::move(grain));
  }
  return out;
}

}  // namespace

std::unique_ptr<const LinearResponse> linear_response(const Model& model, const State& state, double share) {
  if (state.bonds.size() > 0 || !state.boundary.cell.periodic()) return nullptr;
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
    if (now <= 0 || (l.friction > 0 && (l.spring + change - along * l.normal).norm() > l.friction * now))
      outside += std::max(l.force, now);
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
