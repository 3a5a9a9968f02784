// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <tuple>
#include <utility>

// Tables: tuples of entries with a `value` each, such as a reference to a member.

namespace tactel::host {

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

}  // namespace tactel::host
