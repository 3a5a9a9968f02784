#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

namespace tactel::nn {

/// In which order a cycle shows its patterns. Both are in the program that the paper's rule comes from (McClelland and
/// Rumelhart 1988, program bp: strain and ptrain). `permuted` is the default: the load steps of one contact stand side
/// by side in a set and resemble each other, and with momentum 0.9 the network would chase each contact in turn.
enum class PresentationOrder { permuted, sequential };

const char* name(PresentationOrder order);
/// "permuted" or "sequential". Throws ValueError, key "order".
PresentationOrder parse_order(std::string_view text);

/// The rows 0 ... rows - 1 in the order of `cycle`: Fisher and Yates' shuffle in Durstenfeld's form (CACM algorithm
/// 235) from i = rows - 1 down to 1, step s = rows - 1 - i swapping i with the row at floor(word (i + 1) / 2^32), where
/// word is number s % 4 of random_words(seed, order, s / 4, cycle). Each cycle starts from 0, 1, 2, ...
std::vector<std::uint32_t> presentation_order(PresentationOrder order, std::uint64_t seed, std::uint32_t cycle,
                                              std::uint32_t rows);

}  // namespace tactel::nn
