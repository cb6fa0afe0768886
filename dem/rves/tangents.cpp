// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/tangents.hpp"

#include <algorithm>

#include "dem/rve/tangent.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::dem {

namespace {

Misses misses(const Sweep& before, const Sweep& now) {
  double miss = 0, all = 0;
  for (std::size_t i = 0; i < now.answer.size(); ++i) {
    const Answer &a = before.answer[i], &b = now.answer[i];
    all += b.stress.squaredNorm();
    const Vec6 strain = strain_between(before.deformation[i], now.deformation[i]);
    const Mat3 elastic = from_voigt(a.tangent * strain);
    const double off = (b.stress - a.stress - elastic).norm();
    miss += std::pow(b.breakages != a.breakages ? off : std::max(0.0, off - elastic.norm()), 2);
  }
  return {miss, all, 1};
}

double share(const Misses& m) { return m[1] > 0 ? std::sqrt(m[0] / m[1]) : 0; }

}  // namespace

double disagreement(const Sweep& before, const Sweep& now) { return share(misses(before, now)); }

void NoiseMeter::read(const Sweep& before, const Sweep& now, const Joining& join) {
  Misses all = before.deformation.empty() ? Misses{} : misses(before, now);
  if (join) join(all);
  measured = all[2] == 0 ? 0 : std::max(share(all), 0.7 * measured);
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
