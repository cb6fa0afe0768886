// SPDX-License-Identifier: LGPL-3.0-or-later
// What the screens before a test for cracks leave out: no grain that the whole test would break, and most of the cost.
#include "dem/bond/bonds.hpp"
#include "tests/cracking_balls.hpp"
#include "tests/lattices.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

struct Screens {
  std::size_t grains = 0, light = 0, calm = 0, cracks = 0, hidden = 0, blind = 0;
};

/// Every grain of a state is asked in full. `light`, `hidden`: below the screen of force, and those of them that crack;
/// `calm`, `blind`: the same of a screen of stretch away from the contacts.
void ask_all(const Model& model, State state, Screens& screens) {
  index_bonds(state.grains.size(), state.bonds, state.break_room.bonds);
  const CrackTests& tests = *model.materials[0].fracture->cracks;
  const Grains& g = state.grains;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const CrackResult found = ask_for_cracks(model, state, i);
    const double utilisation =
        judge(model.materials[0].fracture->criteria, loaded_hull(model, state, i), g.strength[i]).utilisation;
    const bool light = utilisation < tests.force_screen, calm = !light && found.core_stretch < 0.55,
               cracks = found.verdict == CrackVerdict::cracks;
    ++screens.grains, screens.light += light, screens.calm += calm, screens.cracks += cracks;
    screens.hidden += cracks && light, screens.blind += cracks && calm;
  }
}

/// Balls in a cell at some instants of its compression, as strong as to bear anything or little of it.
Screens in_a_cell(std::uint64_t steps, std::uint64_t every) {
  const Model whole = hull_model(0.5);
  Screens screens;
  for (std::uint64_t at = every; at <= steps; at += every) {
    const State pressed = crushed(whole, 1, at);
    double most = 0;
    for (std::size_t k = 0; k < pressed.contacts.size(); ++k)
      if (pressed.contacts.contact.touching(k)) most = std::max(most, pressed.contacts.touch[k].force.norm());
    for (const double share : {0.5, 1.0, 2.0}) {  // of the largest force over the square of a diameter
      const Model model = cracking_rock(most / 4 / share, 300);
      Team team(1);
      State s = pressed;
      prepare(model, s, team);
      ask_all(model, s, screens);
    }
  }
  return screens;
}

void check(const Screens& s) {
  WARN(s.grains << " grains asked, " << s.cracks << " crack; force leaves out " << s.light << ", of which " << s.hidden
                << " crack; stretch would " << s.calm << " more, " << s.blind);
  CHECK(s.hidden == 0);
  CHECK(s.cracks > s.grains / 50);
  CHECK(s.light > s.grains / 5);
}

}  // namespace

TEST_CASE("in a cell of balls the screen of force hides no crack") { check(in_a_cell(30, 15)); }

TEST_CASE("nor does it in many instants", "[.slow]") { check(in_a_cell(60, 2)); }

TEST_CASE("a ball whose contacts leave no bond away from them cracks all the same") {
  LatticeModel m;
  m.lattice.points = 400, m.youngs_modulus = 100e9, m.poissons_ratio = 0.15;
  std::vector<PatchLoad> loads =
      pressed(2e-3, 400);  // a pair that would break it alone, and light ones with wide faces
  for (const Vec3& n : {Vec3(1, 0, 0), Vec3(0, 1, 0)})
    for (const double side : {-1.0, 1.0})
      loads.push_back({side * n * 1e-3, -side * 40 * n, Vec3::Zero(), pi * 0.6e-3 * 0.6e-3});
  const CrackResult found = crack_test(lattice_sphere(1e-3), loads, m, 8e-4, 1, 1);
  CHECK(found.core_stretch == 0);
  CHECK(found.verdict == CrackVerdict::cracks);
}
