// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "host/scenes/toml_table.h"
#include "host/support/nearest_word.h"

namespace tactel::host {

/// A shape of indenters: its word in files, its keys besides those of all shapes, and its defaults.
template <class Shape>
struct ShapeName {
  std::string name;
  std::vector<std::string> keys;
  Shape made;
};

/// Keys and shapes of [indenter] that the other kind of sensor has, and this one lacks.
struct OtherKind {
  std::vector<std::string> keys, shapes;
  std::string is;  ///< "belongs to a pad"

  void refuse(TomlTable& in) const {
    in.refuse_any(keys, "left out: it " + is);
    std::string shape;
    if (in.has_text("shape") && in.read("shape", shape, "") && std::ranges::find(shapes, shape) != shapes.end())
      in.refuse("shape", "another one: it " + is);
  }
};

/// Reads the key `shape` of [indenter] and returns its entry of `shapes`; `usual` where the key is absent. Throws
/// ConfigError where both are, and for keys that belong to another shape or to none; `common`: the keys of all shapes.
template <class Shape>
const ShapeName<Shape>& choose_shape(TomlTable& in, const std::vector<ShapeName<Shape>>& shapes,
                                     const std::vector<std::string>& common, const ShapeName<Shape>* usual = nullptr) {
  std::vector<std::string> names, all = common;
  for (const auto& shape : shapes) {
    names.push_back(shape.name);
    all.insert(all.end(), shape.keys.begin(), shape.keys.end());
  }
  const auto choice = in.read_choice("shape", names);
  if (!choice && usual == nullptr) in.refuse_unknown(all);
  if (!choice && usual == nullptr) in.refuse_missing("shape", "given, one of " + listed(names));
  const ShapeName<Shape>& chosen = choice ? shapes[*choice] : *usual;
  const auto holds = [](const std::vector<std::string>& keys, const std::string& key) {
    return std::ranges::find(keys, key) != keys.end();
  };
  for (const std::string& key : in.keys()) {
    if (holds(chosen.keys, key) || holds(common, key)) continue;
    std::vector<std::string> owners;
    for (const auto& shape : shapes)
      if (holds(shape.keys, key)) owners.push_back(shape.name);
    if (owners.empty()) continue;
    in.refuse(key, "left out: it belongs to shape " + listed(owners) + "; the keys of shape " + chosen.name + " are " +
                       listed(chosen.keys));
  }
  std::vector<std::string> known = common;
  known.insert(known.end(), chosen.keys.begin(), chosen.keys.end());
  in.refuse_unknown(known);
  return chosen;
}

}  // namespace tactel::host
