// SPDX-License-Identifier: LGPL-3.0-or-later
// Benchmarks: one table of measured figures and the machine's limits; peers.py compares.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "dem/kernel/contact_pass.hpp"
#include "dem/rve/step.hpp"
#include "tests/bench/hull_works.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/works.hpp"

using namespace grus::bench;

namespace {

constexpr const char* usage =
    "grus_bench [--out results.csv] [--large]                       the table; --large: up to 1,000,000 grains (some "
    "minutes)\n"
    "grus_bench --packing FILE STEPS [THREADS]                      one run on a packing (\"N L\", then \"x y z r\"), "
    "as RESULT line\n"
    "grus_bench --shapes GRAINS STEPS                               the same on a dense cell of poly-ellipsoids\n"
    "grus_bench --hulls STEPS                                       the rows of hulls alone\n"
    "grus_bench --cell FILE INCREMENTS                              increments of 1e-3 of a cell (\"N\", its nine "
    "numbers, then \"x y z r\")\n"
    "grus_bench --make-packing GRAINS FILE [RATIO]                  such a packing, radii even between 1 and RATIO "
    "(4.5)\n"
    "GRUS_LANES=1|4|8 in the environment chooses narrower kernels.\n";

// Counted in the sources of dem/kernel: multiplications, additions, comparisons, divisions and roots of the stages that
// a touching pair goes through (24 + 43 + 93 + 53), and of a grain's kicks; bytes of its columns and rows.
constexpr double flops_of_contact = 213, flops_of_grain = 45;
constexpr double bytes_of_contact = 48 + 12 + 1, bytes_of_grain = 96;

struct Table {
  std::vector<Row> rows;

  void add(Row row) {
    fmt::print("{:<72} {:>10.4g} {}\n", row.work, row.value, row.unit);
    std::fflush(stdout);
    rows.push_back(std::move(row));
  }
};

Row dense_row(const Sample& sample, std::size_t nominal, int threads, std::uint64_t steps) {
  double contacts = 0, best = 0;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const Timed run = time_steps(sample, steps, threads, 100);
    contacts = run.contacts;
    best = std::max(best,
                    static_cast<double>(sample.state.grains.size()) * static_cast<double>(steps) / run.seconds / 1e6);
  }
  Row row{fmt::format("dense spheres {}, {} thread{}", nominal, threads, threads > 1 ? "s" : ""), "10^6 grain-steps/s",
          best};
  row.bytes = contacts * bytes_of_contact + bytes_of_grain;
  row.flops = contacts * flops_of_contact + flops_of_grain;
  row.touched = row.bytes * static_cast<double>(sample.state.grains.size());
  return row;
}

void time_all(Table& table, bool large) {
  std::map<std::size_t, Sample> boxes;
  for (const auto& [grains, steps] :
       std::vector<std::pair<std::size_t, std::uint64_t>>{{1000, 4000}, {10000, 1000}, {50000, 200}}) {
    boxes[grains] = boxed(make_packing(grains, 4.5));
    for (const int threads : {1, 2}) table.add(dense_row(boxes[grains], grains, threads, steps));
  }
  {
    Timed run = time_steps(boxes[10000], 2000, 1, 100);
    table.add({"neighbour rebuilds, dense spheres 10000, of the time", "%", 100 * share_of_lists(boxes[10000], run)});
  }
  {
    double full = INFINITY, bare = INFINITY;
    Sample s = boxes[1000];
    s.state.boundary.walls.back().velocity.setZero();
    grus::dem::Team team(1);
    prepare(s.model, s.state, team);
    for (int repeat = 0; repeat < 7; ++repeat)
      full = std::min(full, seconds_of_steps(s, 3000, 1, 0)), bare = std::min(bare, seconds_of_bare_steps(s, 3000));
    table.add({"step loop against contacts and kicks alone, 1000 spheres", "x", full / bare});
  }
  Sample spheres = celled(1000, false, 10e6), shapes = celled(1000, true, 10e6);
  const double of_sphere = contact_nanoseconds(spheres), of_shape = contact_nanoseconds(shapes);
  table.add({"contact pass, spheres, a touching pair", "ns", of_sphere});
  table.add({"contact pass, poly-ellipsoids, a touching pair", "ns", of_shape});
  table.add({"poly-ellipsoid pair against sphere pair", "x", of_shape / of_sphere});
  for (const int threads : {1, 2}) {
    double best = 0;
    for (int repeat = 0; repeat < 3; ++repeat)
      best = std::max(best, 1000.0 * 2000 / seconds_of_steps(shapes, 2000, threads, 100) / 1e6);
    table.add({fmt::format("dense poly-ellipsoids 1000, {} thread{}", threads, threads > 1 ? "s" : ""),
               "10^6 grain-steps/s", best});
  }
  time_hulls(2000, [&](Row row) { table.add(std::move(row)); });
  for (const std::size_t grains : {400u, 1000u}) {
    const Sample cell = celled(grains, false, 1e6);
    const Path i = increments(cell, cell.model.numerics.safety, 6);
    table.add({fmt::format("increment of 1e-3 to unbalanced 1e-3, cell of {} spheres", grains), "s", i.seconds});
    table.add({fmt::format("... its steps"), "steps", i.steps});
    table.add({fmt::format("... its stress against closure to 1e-6"), "relative error", i.error});
    if (grains == 400) {
      table.add({"1000 cells of 400 spheres, 2 threads", "x", farm_speed_up(cell, 1000)});
      table.add({"machine: multiplications and additions in registers, 2 threads", "x", gigaflops(2) / gigaflops(1)});
    }
  }
  std::vector<int> layers{10, 22, 46};
  if (large) layers.push_back(100);
  for (const int k : layers) {
    Sample s = boxed(lattice(k));
    s.state.boundary.walls.back().velocity.setZero();
    const double grains = static_cast<double>(s.state.grains.size());
    const auto steps = static_cast<std::uint64_t>(std::max(20.0, 4e6 / grains));
    const double took = seconds_of_steps(s, steps, 1, 20);
    table.add({fmt::format("growth: a grain and step, lattice of {} grains", s.state.grains.size()), "ns",
               1e9 * took / (grains * static_cast<double>(steps))});
    table.add({"... its neighbour list, a grain", "ns", list_nanoseconds(s)});
    table.add({"... memory of the state", "bytes a grain", bytes_of(s) / grains});
  }
  for (const double ratio : {3.0, 30.0}) {
    const Sample s = boxed(make_packing(20000, ratio));
    const Timed run = time_steps(s, 200, 1, 20);
    table.add({fmt::format("size ratio 1:{}, 20000 grains, a grain and step", ratio), "ns",
               1e9 * run.seconds / (static_cast<double>(s.state.grains.size()) * 200)});
    table.add({fmt::format("... its contacts a grain"), "", run.contacts});
  }
}

int tell(const Sample& sample, std::uint64_t steps, int threads) {
  Timed run = time_steps(sample, steps, threads, 200);
  const auto work = static_cast<double>(sample.state.grains.size() * steps);
  fmt::print(
      "RESULT code=grus N={} steps={} threads={} wall={:.4f} psps={:.6g} contacts_a_grain={:.3f} rebuild_share={:.3f} "
      "stress={:.6g} lanes={}\n",
      sample.state.grains.size(), steps, threads, run.seconds, work / run.seconds, run.contacts,
      steps > 0 ? share_of_lists(sample, run) : 0, run.stress, grus::dem::lanes());
  return 0;
}

/// The default share of the critical step of a run (0.3), that of a unit cell, and the whole of it.
int cell_run(const std::string& file, int count) {
  const Sample sample = read_cell(file);
  for (const double safety : {0.3, 0.7, 0.9}) {
    const Path p = increments(sample, safety, count);
    fmt::print("RESULT code=grus safety={:g} ms={:.3f} steps={:.1f} error={:.3g} stress={:.6g}\n", safety,
               1e3 * p.seconds, p.steps, p.error, p.stress);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string out;
  bool large = false;
  for (int k = 1; k < argc; ++k) {
    if (!std::strcmp(argv[k], "--packing") && k + 2 < argc)
      return tell(boxed(read_packing(argv[k + 1])), std::stoul(argv[k + 2]), k + 3 < argc ? std::stoi(argv[k + 3]) : 1);
    if (!std::strcmp(argv[k], "--shapes") && k + 2 < argc)
      return tell(celled(std::stoul(argv[k + 1]), true, 10e6), std::stoul(argv[k + 2]), 1);
    if (!std::strcmp(argv[k], "--hulls") && k + 1 < argc) {
      Table hulls;
      return time_hulls(std::stoul(argv[k + 1]), [&](Row row) { hulls.add(std::move(row)); }), 0;
    }
    if (!std::strcmp(argv[k], "--cell") && k + 2 < argc) return cell_run(argv[k + 1], std::stoi(argv[k + 2]));
    if (!std::strcmp(argv[k], "--make-packing") && k + 2 < argc)
      return write_packing(argv[k + 2],
                           make_packing(std::stoul(argv[k + 1]), k + 3 < argc ? std::stod(argv[k + 3]) : 4.5)),
             0;
    if (!std::strcmp(argv[k], "--large"))
      large = true;
    else if (!std::strcmp(argv[k], "--out") && k + 1 < argc)
      out = argv[++k];
    else
      return fmt::print(stderr, "{}", usage), 2;
  }
  Table table;
  const double rate = gigaflops();
  table.add({fmt::format("machine: multiplications and additions, {} at a time", grus::dem::lanes()), "10^9/s", rate});
  std::map<double, double> bandwidth;
  for (const double bytes : {1e6, 5e6, 3e7, 2e8}) {
    bandwidth[bytes] = update_bandwidth(bytes);
    table.add({fmt::format("machine: read and written back, {:g} MB", bytes / 1e6), "GB/s", bandwidth[bytes]});
  }
  time_all(table, large);

  fmt::print("\n{:<72} {:>10} {:<20} {:>10} {:>7}\n", "work", "figure", "unit", "limit", "of it");
  std::ostringstream csv;
  csv << "work;figure;unit;machine limit\n";
  for (const auto& row : table.rows) {
    double limit = 0;
    if (row.bytes > 0) {
      const auto room = bandwidth.lower_bound(row.touched);
      const double speed = room == bandwidth.end() ? bandwidth.rbegin()->second : room->second;
      const int threads = row.work.find("2 threads") != std::string::npos ? 2 : 1;
      limit = 1e3 * threads / std::max(row.bytes / speed, row.flops / rate);
    }
    fmt::print("{:<72} {:>10.4g} {:<20} {:>10} {:>7}\n", row.work, row.value, row.unit,
               limit > 0 ? fmt::format("{:.3g}", limit) : "",
               limit > 0 ? fmt::format("{:.0f} %", 100 * row.value / limit) : "");
    csv << fmt::format("{};{:.6g};{};{}\n", row.work, row.value, row.unit,
                       limit > 0 ? fmt::format("{:.6g}", limit) : "");
  }
  if (!out.empty()) std::ofstream(out) << csv.str();
}
