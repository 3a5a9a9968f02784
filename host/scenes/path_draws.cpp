// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/path_draws.h"

#include <toml++/toml.h>

#include <algorithm>

#include "host/support/nearest_word.h"

namespace tactel::host {

const toml::node* DrawTable::find(const char* key) {
  known_.emplace_back(key);
  return table_.get(key);
}

Distribution DrawTable::distribution(const char* key, Distribution otherwise, double least, double most,
                                     const char* allowed) {
  const toml::node* node = find(key);
  if (node == nullptr) return otherwise;
  Distribution read = always(0);
  if (const auto value = toml_number(*node))
    read = always(*value);
  else if (auto drawn = read_distribution(file_, full(key), *node))
    read = *drawn;
  else
    throw file_.error(full(key), node, std::string(allowed) + ", or a distribution of it");
  const auto [low, high] = ends(read);
  if (!(low >= least && high <= most)) throw file_.error(full(key), node, allowed);
  return read;
}

double DrawTable::number(const char* key, double otherwise, double least, double most, const char* allowed) {
  const toml::node* node = find(key);
  if (node == nullptr) return otherwise;
  const auto value = toml_number(*node);
  if (!value || !(*value >= least && *value <= most)) throw file_.error(full(key), node, allowed);
  return *value;
}

double DrawTable::probability(const char* key, double otherwise) {
  return number(key, otherwise, 0, 1, "a probability, 0 to 1");
}

int DrawTable::whole(const char* key, int otherwise, int least, int most, const char* allowed) {
  const toml::node* node = find(key);
  if (node == nullptr) return otherwise;
  const auto value = node->value_exact<std::int64_t>();
  if (!value || *value < least || *value > most) throw file_.error(full(key), node, allowed);
  return static_cast<int>(*value);
}

bool DrawTable::second(const char* key, const char* first, const char* second, bool otherwise) {
  const toml::node* node = find(key);
  if (node == nullptr) return otherwise;
  const auto word = node->value_exact<std::string>();
  if (!word || (*word != first && *word != second))
    throw file_.error(full(key), node, std::string("\"") + first + "\" or \"" + second + "\"");
  return *word == second;
}

void DrawTable::finish() const {
  for (const auto& [key, node] : table_)
    if (std::ranges::find(known_, key.str()) == known_.end())
      throw file_.error(name_ + "." + std::string(key.str()), &node,
                        "one of " + listed(known_) + did_you_mean(key.str(), known_));
}

}  // namespace tactel::host
