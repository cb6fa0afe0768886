// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/deferral.hpp"

#include <algorithm>

#include "dem/rves/prediction.hpp"

namespace grus::dem {

Told told(const Memory& m, const Mat3& increment) {
  if (!m.trial) return {m.stress, m.tangent, increment * m.pending};
  return {m.trial->response.stress, m.trial->response.tangent, increment * m.trial->increment.inverse()};
}

bool Deferral::foretells(const Memory& m, const Mat3& increment) const {
  if (tolerance <= 0 || (!m.heard && !m.trial)) return false;
  const Told last = told(m, increment);
  Mat3 r, u;
  polar(last.beyond, r, u);
  const double change = from_voigt(last.tangent * strain_between(Mat3::Identity(), u)).norm();
  return change <= m.trust * tolerance * scale(last.stress);
}

double Deferral::caught_up(Memory& m, const Response& r) const {
  const double error = (predicted(m.stress, m.tangent, m.pending) - r.stress).norm() / scale(r.stress);
  m.trust = std::clamp(m.trust * 0.9 * tolerance / std::max(error, 1e-12), 0.05, 1.0);
  m.stress = r.stress;
  m.tangent = r.tangent;
  m.pending.setIdentity();
  return error;
}

const Response* commit(Memory& m, const Mat3& increment, bool deferred, const Response& answer) {
  if (deferred) m.pending = told(m, increment).beyond;
  if (deferred && !m.trial) return nullptr;
  const Response* done = m.trial ? &m.trial->response : &answer;
  m.heard = true;
  m.stress = done->stress;
  m.tangent = done->tangent;
  if (!deferred) m.pending.setIdentity();
  return done;
}

}  // namespace grus::dem
