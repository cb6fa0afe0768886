// SPDX-License-Identifier: LGPL-3.0-or-later
// Values as bytes and back: one walk over the members serves saving, loading and the number of the layout, so these
// cannot drift apart, and a new member is saved without a line here.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "dem/base/error.hpp"
#include "dem/base/members.hpp"

namespace grus::dem {

/// True for types that follow from what is saved, and for room that is used again: no bytes hold them.
template <class T>
inline constexpr bool made_again = false;

template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t N>
inline constexpr bool is_array<std::array<T, N>> = true;
template <class T>
inline constexpr bool is_variant = false;
template <class... T>
inline constexpr bool is_variant<std::variant<T...>> = true;

template <class T>
inline constexpr int size_of_eigen = 1;
template <class T>
requires requires { T::SizeAtCompileTime; }
inline constexpr int size_of_eigen<T> = T::SizeAtCompileTime;

/// A number, or numbers of a fixed size side by side (Eigen's vectors, matrices, quaternions).
template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T> || requires {
  typename T::Scalar;
  requires size_of_eigen<T> >
  0;
};

/// True where the bytes of a value are those of its members, with nothing in between that nobody writes.
template <class T>
constexpr bool solid() {
  if constexpr (Number<T>) {
    return true;
  } else if constexpr (is_array<T>) {
    return solid<typename T::value_type>();
  } else if constexpr (!std::is_aggregate_v<T> || made_again<T>) {
    return false;
  } else {
    return []<class... M>(std::type_identity<std::tuple<M&...>>) {
      return (solid<M>() && ...) && (sizeof(M) + ... + 0) == sizeof(T);
    }(std::type_identity<decltype(members_of(std::declval<T&>()))>{});
  }
}

class Saver {
public:
  template <class T>
  void plain(const T& v) {
    static_assert(solid<T>(), "bytes that nobody writes: walk() saves such values member by member");
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class T>
  void column(const std::vector<T>& v) {
    static_assert(solid<T>(), "bytes that nobody writes: walk() saves such rows member by member");
    plain(static_cast<std::uint64_t>(v.size()));
    bytes_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T));
  }
  template <class T, class F>
  void rows(const std::vector<T>& v, F&& each) {
    plain(static_cast<std::uint64_t>(v.size()));
    for (const T& row : v) each(row);
  }
  template <class T, class F>
  void optional(const std::optional<T>& v, F&& each) {
    plain(v.has_value());
    if (v) each(*v);
  }
  template <class... T, class F>
  void kinds(const std::variant<T...>& v, F&& each) {
    plain(static_cast<std::uint8_t>(v.index()));
    std::visit(each, v);
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
    static_assert(solid<T>());
    std::memcpy(static_cast<void*>(&v), next(sizeof v), sizeof v);
  }
  template <class T>
  void column(std::vector<T>& v) {
    static_assert(solid<T>());
    const std::size_t n = size(sizeof(T));
    v.resize(n);
    if (n > 0) std::memcpy(static_cast<void*>(v.data()), next(n * sizeof(T)), n * sizeof(T));
  }
  template <class T, class F>
  void rows(std::vector<T>& v, F&& each) {
    v.clear();
    for (std::size_t n = size(1); n > 0; --n) each(v.emplace_back());  // grows as bytes come: no number takes memory
  }
  template <class T, class F>
  void optional(std::optional<T>& v, F&& each) {
    bool there;
    plain(there);
    v.reset();
    if (there) each(v.emplace());
  }
  template <class... T, class F>
  void kinds(std::variant<T...>& v, F&& each) {
    std::uint8_t kind;
    plain(kind);
    if (kind >= sizeof...(T)) throw InputError("checkpoint holds a kind that is not known");
    std::uint8_t k = 0;
    ((k++ == kind ? each(v.template emplace<T>()) : void()), ...);
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

/// What is walked, in its order, down to the kinds and sizes of the numbers of a row, as a number that does not hang on
/// what is there. Another one tells bytes of another layout.
class Layout {
public:
  template <class T>
  void plain(const T& v) {
    if constexpr (std::is_enum_v<T>) {
      add('e', sizeof(T));
    } else if constexpr (std::is_floating_point_v<T>) {
      add('f', sizeof(T));
    } else if constexpr (std::is_arithmetic_v<T>) {
      add('i', sizeof(T));
    } else if constexpr (Number<T> || is_array<T>) {
      add('n', sizeof(T));
    } else {
      add('{', sizeof(T));
      for_each_member(v, [&](const auto& member) { plain(member); });
    }
  }
  template <class T>
  void column(const std::vector<T>&) {
    add('c', sizeof(T));
    plain(T{});
  }
  template <class T, class F>
  void rows(const std::vector<T>&, F&& each) {
    add('r', sizeof(T));
    const T any{};
    each(any);
  }
  template <class T, class F>
  void optional(const std::optional<T>&, F&& each) {
    add('o', sizeof(T));
    const T any{};
    each(any);
  }
  template <class... T, class F>
  void kinds(const std::variant<T...>&, F&& each) {
    add('v', sizeof...(T));
    const std::tuple<T...> any{};
    std::apply([&](const T&... kind) { (each(kind), ...); }, any);
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

/// All of a value, but for what is made again: that is emptied where bytes are read. A is Saver or Layout with a const
/// value, or Loader.
template <class A, class T>
void walk(A& a, T& v) {
  using V = std::remove_const_t<T>;
  const auto member = [&](auto& m) { walk(a, m); };
  if constexpr (made_again<V>) {
    if constexpr (!std::is_const_v<T>) v = V{};
  } else if constexpr (requires { walk_shared(a, v); }) {
    walk_shared(a, v);
  } else if constexpr (solid<V>()) {
    a.plain(v);
  } else if constexpr (std::is_same_v<V, std::string>) {
    a.text(v);
  } else if constexpr (is_optional<V>) {
    a.optional(v, member);
  } else if constexpr (is_variant<V>) {
    a.kinds(v, member);
  } else if constexpr (is_array<V>) {
    for (auto& each : v) walk(a, each);
  } else if constexpr (is_vector<V>) {
    if constexpr (solid<typename V::value_type>())
      a.column(v);
    else
      a.rows(v, member);
  } else {
    for_each_member(v, member);
  }
}

}  // namespace grus::dem
