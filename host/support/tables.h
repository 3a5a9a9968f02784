// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

namespace tactel::host {

// Tables: tuples of entries, such as options, or with a `value` each, such as a reference to a member.

/// Calls visit(entry) for each of a table.
template <class Table, class Visit>
void each(Table&& table, const Visit& visit) {
  std::apply([&](auto&&... all) { (visit(all), ...); }, std::forward<Table>(table));
}

/// Calls visit(to, from) for the values of the entries of two tables of one size.
template <class... To, class... From, class Visit>
void each_pair(const std::tuple<To...>& to, const std::tuple<From...>& from, const Visit& visit) {
  static_assert(sizeof...(To) == sizeof...(From));
  [&]<std::size_t... i>(std::index_sequence<i...>) { (visit(std::get<i>(to).value, std::get<i>(from).value), ...); }
  (std::index_sequence_for<To...>());
}

/// What an option takes, beside what its type says.
struct Taken {
  std::array<const char*, 7> words{};  ///< one of these; null: no more
  const char* type = nullptr;          ///< its name in the help
  bool positive = false;               ///< above 0
  double least = 0, most = 0;          ///< of a range; both 0: none
  const char* key = nullptr;           ///< in Python, where it is not the flag's
};

/// An option, whose value is a member of a struct: all that the command line, its help, errors and Python say of it.
template <class Owner, class M>
struct Option {
  constexpr Option(const char* names, M Owner::*member, const char* place, const char* help, Taken taken = {})
      : names(names), member(member), place(place), help(help), taken(taken) {}
  const char* names;  ///< "--cycles,--epochs"
  M Owner::*member;
  const char* place;  ///< in the help: "Learning:2", the second of this group
  const char* help;
  Taken taken;

  std::string flag() const { return std::string(names).substr(0, std::string(names).find(',')); }
  /// "warm_up" of "--warm-up".
  std::string key() const {
    if (taken.key != nullptr) return taken.key;
    std::string text = flag().substr(2);
    std::ranges::replace(text, '-', '_');
    return text;
  }
};

/// Returns the flag of the option with this member.
template <class Table, class Owner, class M>
std::string flag_of(const Table& table, M Owner::*member) {
  std::string flag;
  each(table, [&]<class O, class V>(const Option<O, V>& option) {
    if constexpr (std::is_same_v<V O::*, M Owner::*>)
      if (option.member == member) flag = option.flag();
  });
  return flag;
}

}  // namespace tactel::host
