// SPDX-License-Identifier: LGPL-3.0-or-later
// A state comes back whole from its bytes: every member of every part, found by what the structs declare and not by a
// list, is given a number of its own, saved, loaded and compared.
#include <fmt/format.h>

#include "dem/io/archive.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;
using grus::for_each_member;

namespace {

/// What a step makes again from the rest, or room that it uses again. Whatever else a struct gains has to be saved.
template <class T>
inline constexpr bool room =
    std::is_same_v<T, Plan> || std::is_same_v<T, HullGuesses> || std::is_same_v<T, PairIndex> ||
    std::is_same_v<T, NeighbourRoom> || std::is_same_v<T, BondTiles> || std::is_same_v<T, FaceOutlines> ||
    std::is_same_v<T, BreakRoom> || std::is_same_v<T, TriangleGrid>;

template <class T>
inline constexpr bool is_surface = std::is_same_v<T, std::shared_ptr<const Triangles>>;
template <class T>
inline constexpr bool is_shared = std::is_same_v<T, std::shared_ptr<const HullStore>> || is_surface<T>;

/// Gives every number below `v` a value that no other has; of a variant, the last of its kinds.
struct Filler {
  double next = 1;

  template <class T>
  void operator()(T& v) {
    if constexpr (room<T>) {
    } else if constexpr (std::is_same_v<T, bool>) {
      v = true;
    } else if constexpr (std::is_arithmetic_v<T>) {
      v = static_cast<T>(next), next += 1;
    } else if constexpr (std::is_enum_v<T>) {
      v = static_cast<T>(1);
    } else if constexpr (std::is_same_v<T, std::string>) {
      v = fmt::format("text {}", next), next += 1;
    } else if constexpr (std::is_same_v<T, Quat>) {
      (*this)(v.coeffs());
    } else if constexpr (requires { typename T::Scalar; }) {
      for (int k = 0; k < v.size(); ++k) v.data()[k] = next, next += 0.25;
    } else if constexpr (is_surface<T>) {
      std::vector<Vec3> corner(3);
      (*this)(corner);
      corner[1].x() += 1, corner[2].y() += 1;  // numbers in a row have no area
      v = std::make_shared<Triangles>(surface_of(corner, {{0, 1, 2}}));
    } else if constexpr (is_shared<T>) {
      HullStore store;
      (*this)(store);
      v = std::make_shared<HullStore>(store);
    } else if constexpr (is_vector<T>) {
      v.resize(3);
      for (auto& each : v) (*this)(each);
    } else if constexpr (is_array<T>) {
      for (auto& each : v) (*this)(each);
    } else if constexpr (is_optional<T>) {
      (*this)(v.emplace());
    } else if constexpr (is_variant<T>) {
      (*this)(v.template emplace<std::variant_size_v<T> - 1>());
    } else {
      for_each_member(v, *this);
    }
  }
};

/// Counts the numbers below two values, and those in which they differ.
struct Comparer {
  int numbers = 0, different = 0;

  template <class T>
  void operator()(const T& p, const T& q) {
    if constexpr (room<T>) {
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>) {
      ++numbers, different += !(p == q);
    } else if constexpr (std::is_same_v<T, Quat>) {
      (*this)(p.coeffs(), q.coeffs());
    } else if constexpr (requires { typename T::Scalar; }) {
      for (int k = 0; k < p.size(); ++k) ++numbers, different += p.data()[k] != q.data()[k];
    } else if constexpr (is_shared<T>) {
      ++numbers, different += !p != !q;
      if (p && q) (*this)(*p, *q);
    } else if constexpr (is_vector<T>) {
      ++numbers, different += p.size() != q.size();
      for (std::size_t k = 0; k < std::min(p.size(), q.size()); ++k) (*this)(p[k], q[k]);
    } else if constexpr (is_array<T>) {
      for (std::size_t k = 0; k < p.size(); ++k) (*this)(p[k], q[k]);
    } else if constexpr (is_optional<T>) {
      ++numbers, different += p.has_value() != q.has_value();
      if (p && q) (*this)(*p, *q);
    } else if constexpr (is_variant<T>) {
      ++numbers, different += p.index() != q.index();
      std::visit(
          [&]<class K>(const K& kind) {
            if (const K* other = std::get_if<K>(&q)) (*this)(kind, *other);
          },
          p);
    } else {
      both(p, q, std::make_index_sequence<grus::member_count<T>()>());
    }
  }

private:
  template <class T, std::size_t... I>
  void both(const T& p, const T& q, std::index_sequence<I...>) {
    const auto ours = grus::members_of(p), theirs = grus::members_of(q);
    ((*this)(std::get<I>(ours), std::get<I>(theirs)), ...);
  }
};

template <class T>
std::string saved(const T& v) {
  Saver saver;
  walk(saver, v);
  return saver.take();
}

template <class T>
T loaded(const std::string& bytes) {
  T v;
  Loader loader(bytes);
  walk(loader, v);
  REQUIRE(loader.at_end());
  return v;
}

}  // namespace

TEST_CASE("every member of a state is in its bytes, and comes back") {
  State all;
  Filler filler;
  filler(all);
  Comparer untouched;
  untouched(all, State{});
  CHECK(untouched.different > 0.99 * untouched.numbers);  // the filler has filled them
  const std::string bytes = saved(all);
  const State back = loaded<State>(bytes);
  Comparer compared;
  compared(all, back);
  CHECK(compared.different == 0);
  CHECK(compared.numbers > 1000);
  CHECK(saved(back) == bytes);
}

TEST_CASE("an empty state comes back empty") {
  const State none;
  const State back = loaded<State>(saved(none));
  Comparer compared;
  compared(none, back);
  CHECK(compared.different == 0);
  CHECK(saved(back) == saved(none));
}

TEST_CASE("each kind of a variant comes back as that kind, and one that is not there is refused") {
  std::vector<Wall> walls(3);
  walls[0].shape = PlaneWall{Vec3(1, 2, 3)}, walls[1].shape = CylinderWall{Vec3(4, 5, 6), 7};
  walls[2].shape = RollerWall{Vec3(8, 9, 10), 11, 12};
  Comparer compared;
  compared(walls, loaded<std::vector<Wall>>(saved(walls)));
  CHECK(compared.different == 0);
  CHECK(compared.numbers > 3 * 10);
  std::string bytes = saved(walls[0].shape);
  REQUIRE(bytes.size() == 1 + sizeof(PlaneWall));
  bytes[0] = 4;
  CHECK_THROWS_AS(loaded<WallShape>(bytes), InputError);
}

TEST_CASE("equal rows have equal bytes, whatever lay in the memory between their members") {
  CHECK_FALSE(solid<FaceBond>());
  CHECK_FALSE(solid<BondEnds>());
  CHECK_FALSE(solid<HullRow>());
  CHECK(solid<Motion>());
  CHECK(solid<Pair>());
  alignas(FaceBond) unsigned char first[sizeof(FaceBond)], second[sizeof(FaceBond)];
  std::memset(first, 0x11, sizeof first), std::memset(second, 0x77, sizeof second);
  auto *p = new (first) FaceBond, *q = new (second) FaceBond;
  Filler f, g;
  f(*p), g(*q);
  CHECK(std::memcmp(first, second, sizeof first) != 0);
  CHECK(saved(std::vector<FaceBond>{*p}) == saved(std::vector<FaceBond>{*q}));
  CHECK(saved(*p) == saved(*q));
}

TEST_CASE("bytes that end early, or tell of more than there is, are refused and take no memory") {
  State all;
  Filler filler;
  filler(all);
  const std::string bytes = saved(all);
  for (const std::size_t length : {std::size_t{0}, std::size_t{5}, bytes.size() / 2, bytes.size() - 1})
    CHECK_THROWS_AS(loaded<State>(bytes.substr(0, length)), InputError);
  std::string huge = saved(std::vector<FaceBond>(1));
  const std::uint64_t many = huge.size();  // as many rows as bytes: of some 600 bytes each
  std::memcpy(huge.data(), &many, sizeof many);
  CHECK_THROWS_AS(loaded<std::vector<FaceBond>>(huge), InputError);
}
