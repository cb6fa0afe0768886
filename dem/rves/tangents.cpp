// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/tangents.hpp"

#include <algorithm>

#include "dem/rve/tangent.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::dem {

double disagreement(const Sweep& before, const Sweep& now) {
  double miss = 0, all = 0;
  for (std::size_t i = 0; i < now.answer.size(); ++i) {
    const Answer &a = before.answer[i], &b = now.answer[i];
    all += b.stress.squaredNorm();
    const Vec6 strain = strain_between(before.deformation[i], now.deformation[i]);
    const Mat3 elastic = from_voigt(a.tangent * strain);
    const double off = (b.stress - a.stress - elastic).norm();
    miss += std::pow(b.breakages != a.breakages ? off : std::max(0.0, off - elastic.norm()), 2);
  }
  return all > 0 ? std::sqrt(miss / all) : 0;
}

void NoiseMeter::read(const Sweep& before, const Sweep& now) {
  measured = before.deformation.empty() ? 0 : std::max(disagreement(before, now), 0.7 * measured);
}

void choose_tangents(TangentKind kind, const Sweep& before, Sweep& now, std::vector<Mat6>& kept) {
  if (kind != TangentKind::elastic && kind != TangentKind::quasi_newton) return;
  const bool first = kept.empty(), improve = kind == TangentKind::quasi_newton && !before.deformation.empty();
  kept.resize(now.answer.size());
  for (std::size_t i = 0; i < now.answer.size(); ++i) {
    Answer& r = now.answer[i];
    if (first)
      kept[i] = r.tangent;
    else if (improve)
      broyden_update(strain_between(before.deformation[i], now.deformation[i]),
                     to_voigt(r.stress - before.answer[i].stress), kept[i]);
    r.tangent = kept[i];
  }
}

}  // namespace grus::dem
