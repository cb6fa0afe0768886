// SPDX-License-Identifier: LGPL-3.0-or-later
// A state as bytes and back: one list of fields serves both ways, so saving and loading cannot drift apart.
#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "dem/base/error.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

class Saver {
public:
  template <class T>
  void plain(const T& v) {
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class T>
  void column(const std::vector<T>& v) {
    plain(static_cast<std::uint64_t>(v.size()));
    bytes_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T));
  }
  template <class T>
  void optional(const std::optional<T>& v) {
    plain(v.has_value());
    if (v) plain(*v);
  }
  void text(const std::string& v) {
    plain(static_cast<std::uint64_t>(v.size()));
    bytes_ += v;
  }
  std::string take() { return std::move(bytes_); }

private:
  std::string bytes_;
};

/// Throws InputError where the bytes end too early.
class Loader {
public:
  explicit Loader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  void plain(T& v) {
    std::memcpy(static_cast<void*>(&v), next(sizeof v), sizeof v);
  }
  template <class T>
  void column(std::vector<T>& v) {
    const std::size_t n = size(sizeof(T));
    v.resize(n);
    if (n > 0) std::memcpy(static_cast<void*>(v.data()), next(n * sizeof(T)), n * sizeof(T));
  }
  template <class T>
  void optional(std::optional<T>& v) {
    bool there;
    plain(there);
    if (there) plain(v.emplace());
  }
  void text(std::string& v) {
    const std::size_t n = size(1);
    v.assign(next(n), n);
  }
  bool at_end() const { return bytes_.empty(); }

private:
  const char* next(std::size_t n) {
    if (n > bytes_.size()) throw InputError("checkpoint is cut short");
    const char* at = bytes_.data();
    bytes_.remove_prefix(n);
    return at;
  }
  std::size_t size(std::size_t each) {
    std::uint64_t n;
    plain(n);
    if (n > bytes_.size() / each) throw InputError("checkpoint is cut short");
    return n;
  }
  std::string_view bytes_;
};

/// A number of all fields that are walked, in their order, by kind and size of their rows. Another number tells bytes
/// of another layout.
class Layout {
public:
  template <class T>
  void plain(const T&) {
    add('p', sizeof(T));
  }
  template <class T>
  void column(const std::vector<T>&) {
    add('c', sizeof(T));
  }
  template <class T>
  void optional(const std::optional<T>&) {
    add('o', sizeof(T));
  }
  void text(const std::string&) { add('t', 1); }
  std::uint64_t number() const { return number_; }

private:
  void add(char kind, std::size_t size) {
    for (const std::uint64_t v : {std::uint64_t(static_cast<unsigned char>(kind)), std::uint64_t(size)})
      number_ = (number_ ^ v) * 0x100000001b3ULL;  // FNV-1a
  }
  std::uint64_t number_ = 0xcbf29ce484222325ULL;
};

template <class A, class C>
void archive_contacts(A& a, C& c) {
  a.plain(c.begin);
  for (auto& starts : c.tile) a.column(starts);
  for (auto& starts : c.apart) a.column(starts);
  a.plain(c.contact.rolls), a.plain(c.contact.reaches);
  for_each_contact_column(c.contact, [&](auto& column) { a.column(column); });
  a.column(c.pair);
  a.column(c.touch);
  a.column(c.spot);
  a.plain(c.spots);
  a.column(c.resting_normal);
  a.column(c.a);
  a.column(c.b);
  a.column(c.law);
  a.column(c.shift);
  a.column(c.images);
  a.column(c.active);
  a.column(c.target);
  a.column(c.load);
  a.column(c.remote);
  a.column(c.remote_row);
  a.column(c.tile_work);
  a.column(c.before);
  a.column(c.taken);
  a.column(c.done);
  a.column(c.moved);
  a.plain(c.round);
  a.column(c.first);
  a.column(c.entry);
  a.column(c.energy);
}

/// Archives what states share with each of them: a checkpoint needs nothing else.
template <class A, class P>
void archive_hulls(A& a, P& shared) {
  HullStore store = shared ? *shared : HullStore{};
  a.column(store.vertex);
  a.column(store.plane);
  a.column(store.begin);
  a.column(store.loop);
  a.column(store.column);
  a.column(store.edge);
  a.column(store.row);
  if constexpr (!std::is_const_v<P>)
    shared = store.row.empty() ? nullptr : std::make_shared<HullStore>(std::move(store));
}

template <class A, class L>
void archive_ledger(A& a, L& l) {
  for (auto* v :
       {&l.work,         &l.friction,      &l.damping,        &l.local_damping, &l.bond_damping, &l.fracture,
        &l.split,        &l.split_added,   &l.reshape,        &l.inertia,       &l.unexplained,  &l.most_friction,
        &l.most_damping, &l.most_fracture, &l.most_work,      &l.bond_friction, &l.handed,       &l.start,
        &l.floor,        &l.fracture_area, &l.residual_force, &l.adhesion})
    a.plain(*v);
  for (auto* v : {&l.breakages, &l.bonds_broken}) a.plain(*v);
  a.plain(l.fines.mass);
  a.plain(l.fines.kinetic);
  a.plain(l.fines.volume);
  a.plain(l.fines.momentum);
  a.plain(l.fines.angular_momentum);
  a.column(l.fines.classes);
  a.plain(l.splits);
}

/// Every field of a state that decides how it goes on. A is Saver with a const state, or Loader.
template <class A, class S>
void archive(A& a, S& s) {
  for_each_column(s.grains, [&](auto& column) { a.column(column); });
  a.plain(s.grains.next_id);
  archive_hulls(a, s.grains.hulls);
  archive_contacts(a, s.contacts);
  for_each_kind(s.bonds, [&](auto& column) {
    a.column(column.row);
    if constexpr (!std::is_const_v<S>) column.tiles = {};
  });
  if constexpr (!std::is_const_v<S>) s.bonds.outline.clear();
  a.column(s.bonds.dashpot);
  a.column(s.bonds.wall);
  a.column(s.bonds.load);
  a.column(s.bonds.handed);
  a.column(s.bonds.broken);
  std::uint64_t walls = s.boundary.walls.size();
  a.plain(walls);
  if constexpr (!std::is_const_v<S>) s.boundary.walls.resize(walls);
  for (auto& w : s.boundary.walls)
    a.plain(w.point), a.plain(w.normal), a.plain(w.velocity), a.plain(w.material), a.plain(w.axis), a.plain(w.radius),
        a.plain(w.roller), a.plain(w.hull), a.text(w.name);
  a.plain(s.boundary.cell);
  archive_ledger(a, s.ledger);
  auto& r = s.reference;
  a.column(r.position);
  a.column(r.orientation);
  a.column(r.radius);
  a.column(r.wall_point);
  a.plain(r.cell);
  a.plain(r.skin);
  a.plain(r.grown);
  a.plain(r.largest);
  a.plain(r.travelled);
  a.plain(r.builds);
  a.plain(r.mends);
  a.column(r.bonded);
  a.column(r.walled);
  a.plain(r.stale);
  a.column(s.grain_energy);
  for (auto* v : {&s.time, &s.dt, &s.skin, &s.mean_radius, &s.grain_pressure}) a.plain(*v);
  for (auto* v : {&s.steps, &s.next_estimate, &s.estimate_interval, &s.listed_at, &s.sorted, &s.tested_at, &s.next_test,
                  &s.grain_steps})
    a.plain(*v);
  a.plain(s.servo);
  a.plain(s.resting);
}

/// The layout of every field of a state, a wall's among them.
inline std::uint64_t layout_of_states() {
  State one;
  one.boundary.walls.resize(1);
  Layout layout;
  archive(layout, std::as_const(one));
  return layout.number();
}

inline std::string bytes_of(const State& state) {
  Saver saver;
  archive(saver, state);
  return saver.take();
}

inline State state_of(std::string_view bytes) {
  State state;
  Loader loader(bytes);
  archive(loader, state);
  if (!loader.at_end()) throw InputError("checkpoint holds more than a state");
  return state;
}

}  // namespace grus::dem
