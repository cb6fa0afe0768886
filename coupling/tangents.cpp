// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/tangents.hpp"

#include <algorithm>

#include "dem/rve/tangent.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::coupling {

double disagreement(const Sweep& before, const Sweep& now) {
  double miss = 0, all = 0;
  for (std::size_t i = 0; i < now.answer.size(); ++i) {
    const Answer &a = before.answer[i], &b = now.answer[i];
    all += b.stress.squaredNorm();
    const dem::Vec6 strain = dem::strain_between(before.deformation[i], now.deformation[i]);
    const dem::Mat3 elastic = dem::from_voigt(a.tangent * strain);
    const double off = (b.stress - a.stress - elastic).norm();
    miss += std::pow(b.breakages != a.breakages ? off : std::max(0.0, off - elastic.norm()), 2);
  }
  return all > 0 ? std::sqrt(miss / all) : 0;
}

void NoiseMeter::read(const Sweep& before, const Sweep& now) {
  measured = before.deformation.empty() ? 0 : std::max(disagreement(before, now), 0.7 * measured);
}

void choose_tangents(dem::TangentKind kind, const Sweep& before, Sweep& now, std::vector<dem::Mat6>& kept) {
  if (kind != dem::TangentKind::elastic && kind != dem::TangentKind::quasi_newton) return;
  const bool first = kept.empty(), improve = kind == dem::TangentKind::quasi_newton && !before.deformation.empty();
  kept.resize(now.answer.size());
  for (std::size_t i = 0; i < now.answer.size(); ++i) {
    Answer& r = now.answer[i];
    if (first)
      kept[i] = r.tangent;
    else if (improve)
      dem::broyden_update(dem::strain_between(before.deformation[i], now.deformation[i]),
                          dem::to_voigt(r.stress - before.answer[i].stress), kept[i]);
    r.tangent = kept[i];
  }
}

}  // namespace grus::coupling
