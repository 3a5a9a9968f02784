// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace tactel::nn {

/// Order of the patterns in a cycle. Both orders are in the program that the rule of the paper comes from
/// (McClelland and Rumelhart 1988, program bp: strain and ptrain). Defaults to `permuted`: adjacent rows of a set
/// are load steps of one contact and resemble each other. In sequential order, with momentum 0.9, the network
/// would follow each contact in turn.
enum class PresentationOrder { permuted, sequential };

const char* name(PresentationOrder order);
/// Returns the order named "permuted" or "sequential". Throws ValueError, key "order".
PresentationOrder parse_order(std::string_view text);

/// Returns the rows 0 ... rows - 1 in the order of `cycle`. The algorithm is Fisher and Yates' shuffle in
/// Durstenfeld's form (CACM algorithm 235), from i = rows - 1 down to 1. Step s = rows - 1 - i swaps i with the
/// row at floor(word (i + 1) / 2^32), where word is number s % 4 of random_words(seed, order, s / 4, cycle). Each
/// cycle starts from 0, 1, 2, ...
std::vector<std::uint32_t> presentation_order(PresentationOrder order, std::uint64_t seed, std::uint32_t cycle,
                                              std::uint32_t rows);

}  // namespace tactel::nn
