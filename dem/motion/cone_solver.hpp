// SPDX-License-Identifier: LGPL-3.0-or-later
// Contacts solved for all at once: impulses in Coulomb's cones that minimise
//   1/2 g . (N + C) g + g . r,   N = J M^-1 J^T,
// g the impulses of all rows, C their compliances, r the velocities that the rows would have without any impulse. At
// the minimum each contact's velocity w = (N + C) g + r is in the dual cone and does no work on g: what presses does
// not part, what sticks does not slide; what slides parts by friction x slip as well. Anitescu, Math. Program. 105
// (2006) 113; by accelerated projected gradients as Mazhar et al., ACM Trans. Graph. 34 (2015) 32, in columns scaled by
// the contacts' own diagonal of N + C. That parting is taken back on the way: r grows along the normal by friction x
// slip as it is found (de Saxce and Feng, Math. Comput. Modelling 28 (1998) 225), which leaves Coulomb's law.
#pragma once

#include <array>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/base/tensor.hpp"

namespace grus::dem {

/// A body as the solver knows it: what it does with an impulse. The inertia is about the mass centre, global.
struct ConeBody {
  double inverse_mass = 0;              // 1/kg
  Mat3 inverse_inertia = Mat3::Zero();  // 1/(kg m^2)
};

/// The rows of a contact: the cone's - along the normal, two along the plane, spin about the normal times an arm - and
/// two that rock about axes in the plane, which know no bound.
enum ConeRow : std::size_t { press_row, slide_row, spin_row = 3, rock_row, cone_rows = 6 };
using ConeRows = std::array<double, cone_rows>;

struct ConeContact {
  static constexpr Index fixed = ~Index{0};  // as b: what does not give way
  Index a = 0, b = fixed;
  Vec3 normal = Vec3::UnitX(), across = Vec3::UnitY();  // from a to b; the plane's first axis
  Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();      // from the mass centres (m)
  double friction = 0;
  double spin_arm = 0;  // m; 0: no friction against spin
  bool rocks = false;
  double slip = 0;        // m/s, at which it is thought to slide: where the search begins
  ConeRows compliance{};  // m/(N s^2) of the first four rows, rad/(N m s^2) of those that rock
  ConeRows free{};        // r: m/s, rad/s
};

/// A force, impulse or velocity along the rows of a contact, those of spin and rocking apart; and back, global.
inline ConeRows along(const ConeContact& c, const Vec3& v) {
  return {c.normal.dot(v), c.across.dot(v), c.normal.cross(c.across).dot(v)};
}
inline Vec3 global(const ConeContact& c, const ConeRows& rows) {
  return rows[0] * c.normal + rows[1] * c.across + rows[2] * c.normal.cross(c.across);
}

struct ConeSettings {
  double tolerance = 1e-4;  // of the impulses' norm
  double by_overlap = 0.1;  // of the same: what overlaps at the end of the step would press with is no further off
  int iterations = 2000;    // at most
  bool parts = false;       // what slides parts by friction x slip, as the minimum has it; else r is raised by that
  double least = 0;         // N s: the norm, if it is less, counts as this
  double wish = 1;          // of both: so much better is sought for in the first `wished` iterations
  int wished = 300;
};

struct ConeEnd {
  int iterations = 0;
  double residual = 0;    // how far a step of the projected gradient in each contact's own scale would go, relative
  double by_overlap = 0;  // how far the impulses are from those that the velocities give to compliant contacts
  bool found(const ConeSettings& asked, double share = 1) const {
    return residual <= share * asked.tolerance && by_overlap <= share * asked.by_overlap;
  }
};

class ConeSolver {
public:
  /// `impulse`: one entry a contact; where it starts, and what is found (N s, N m s).
  ConeEnd solve(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts,
                const ConeSettings& settings, std::vector<ConeRows>& impulse, Team& team);

  /// What impulses do to the bodies: changes of velocity and spin.
  struct Change {
    Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  };
  const std::vector<Change>& changes(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts,
                                     const std::vector<ConeRows>& impulse, Team& team);

  /// What they do to a contact's rows: velocities (m/s, rad/s), after `changes`.
  ConeRows moved(const ConeContact& contact) const;

private:
  struct Scale {
    ConeRows row;     // impulse of a unit of the scaled column
    double friction;  // of the scaled columns: press and plane have scales of their own
  };
  ConeEnd descend(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts, double length,
                  const ConeSettings& settings, Team& team);
  void scale(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts);
  void index(std::size_t bodies, const std::vector<ConeContact>& contacts);
  /// Raises r by what is left of friction x slip; after `apply` of x_.
  void take_back_parting(const std::vector<ConeContact>& contacts, Team& team);
  double largest(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts, Team& team);
  /// (N + C) g, and + r where `whole`, in scaled columns.
  void apply(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts,
             const std::vector<ConeRows>& g, bool whole, std::vector<ConeRows>& out, Team& team);
  void push(const std::vector<ConeBody>& bodies, const std::vector<ConeContact>& contacts,
            const std::vector<ConeRows>& g, bool scaled, Team& team);

  struct Wrench {
    Vec3 force, couple;  // about the contact
  };
  std::vector<Scale> scale_;
  std::vector<Wrench> wrench_;
  std::vector<Change> change_;
  std::vector<Index> first_, entry_;  // contacts by body: 2 x contact + (is b)
  std::vector<ConeRows> x_, y_, next_, gradient_;
  std::vector<double> parting_;  // m/s, by contact: what r has been raised by along the normal
  std::vector<std::array<double, 3>> block_;
};

}  // namespace grus::dem
