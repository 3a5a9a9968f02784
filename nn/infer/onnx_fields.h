// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "nn/infer/protobuf.h"

namespace tactel::infer {

// Numbers of the fields, and values of types (onnx.proto of ONNX 1.8).
enum ModelField : std::uint32_t {
  ir_version = 1,
  producer_name = 2,
  producer_version = 3,
  doc_string = 6,
  graph = 7,
  opset_import = 8,
  metadata_props = 14
};
enum OpsetField : std::uint32_t { opset_domain = 1, opset_version = 2 };
enum EntryField : std::uint32_t { entry_key = 1, entry_value = 2 };
enum GraphField : std::uint32_t {
  graph_node = 1,
  graph_name = 2,
  graph_tensor = 5,
  graph_input = 11,
  graph_output = 12
};
enum NodeField : std::uint32_t {
  node_input = 1,
  node_output = 2,
  node_name = 3,
  node_type = 4,
  node_attribute = 5,
  node_domain = 7
};
enum AttributeField : std::uint32_t {
  attribute_name = 1,
  attribute_f = 2,
  attribute_i = 3,
  attribute_t = 5,
  attribute_ints = 8,
  attribute_type = 20
};
enum AttributeType : std::uint64_t { type_int = 2, type_ints = 7 };
enum NumberType : std::uint64_t { type_float = 1, type_int64 = 7, type_double = 11 };
enum TensorField : std::uint32_t {
  tensor_dims = 1,
  tensor_type = 2,
  tensor_floats = 4,
  tensor_int64s = 7,
  tensor_name = 8,
  tensor_raw = 9,
  tensor_doubles = 10,
  tensor_external = 13
};
enum ValueField : std::uint32_t { value_name = 1, value_type = 2 };
enum TypeField : std::uint32_t { type_tensor = 1, element_type = 1, type_shape = 2, shape_dim = 1 };
enum DimensionField : std::uint32_t { dim_value = 1, dim_param = 2 };

/// Throw Malformed where a field is of another wire type.
inline std::string_view content_of(const Field& field) {
  if (field.wire != Field::bytes) throw Malformed{};
  return field.content;
}
inline std::uint64_t number_of(const Field& field) {
  if (field.wire != Field::varint) throw Malformed{};
  return field.value;
}

/// A file's own words, safe to show: cut to 60 bytes, without control characters.
inline std::string shown(std::string text) {
  constexpr std::size_t most = 60;
  if (text.size() > most) text = text.substr(0, most) + "...";
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

}  // namespace tactel::infer
