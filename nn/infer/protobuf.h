// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tactel::infer {

/// A field of a protobuf message (protobuf.dev, "Encoding").
struct Field {
  enum Wire { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 };
  std::uint32_t number = 0;
  Wire wire = varint;
  std::uint64_t value = 0;        ///< of a varint
  std::string_view content = {};  ///< of bytes
  std::string_view whole = {};    ///< with number and wire type
};

/// Thrown for bytes that are no protobuf message.
struct Malformed {};

/// The fields of a message, one after the other, in place. Reads within the message whatever its bytes are: every
/// length is compared with what is left before it is used.
class Fields {
 public:
  explicit Fields(std::string_view message) : left_(message) {}

  /// Reads the next field. Returns false at the end of the message. Throws Malformed.
  bool next(Field& field) {
    if (left_.empty()) return false;
    const std::string_view from = left_;
    const std::uint64_t tag = read_varint();
    if (tag >> 3 == 0 || tag >> 3 > most_field_number) throw Malformed{};
    field.number = static_cast<std::uint32_t>(tag >> 3);
    field.wire = static_cast<Field::Wire>(tag & 7);
    field.value = 0, field.content = {};
    if (field.wire == Field::varint)
      field.value = read_varint();
    else if (field.wire == Field::bytes)
      field.content = take(read_varint());
    else if (field.wire == Field::fixed64 || field.wire == Field::fixed32)
      field.content = take(field.wire == Field::fixed64 ? 8 : 4);
    else
      throw Malformed{};  // groups, which ONNX has none of
    field.whole = from.substr(0, from.size() - left_.size());
    return true;
  }
  /// Reads the next number of a packed list of varints, whose content is the message. As above.
  bool next(std::uint64_t& number) {
    if (left_.empty()) return false;
    number = read_varint();
    return true;
  }

 private:
  static constexpr std::uint64_t most_field_number = (1u << 29) - 1;

  std::string_view take(std::uint64_t size) {
    if (size > left_.size()) throw Malformed{};
    const std::string_view taken = left_.substr(0, static_cast<std::size_t>(size));
    left_.remove_prefix(static_cast<std::size_t>(size));
    return taken;
  }
  std::uint64_t read_varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<unsigned char>(take(1).front());
      if (shift == 63 && byte > 1) throw Malformed{};
      value |= std::uint64_t{byte & 0x7fu} << shift;
      if (byte < 0x80) return value;
    }
    throw Malformed{};
  }

  std::string_view left_;
};

/// A message that grows field by field.
class Message {
 public:
  void add(std::uint32_t field, std::uint64_t number) {
    append_varint(field << 3 | Field::varint);
    append_varint(number);
  }
  void add(std::uint32_t field, std::string_view content) {
    append_varint(field << 3 | Field::bytes);
    append_varint(content.size());
    bytes_ += content;
  }
  void add(std::uint32_t field, const Message& message) { add(field, std::string_view(message.bytes_)); }
  const std::string& bytes() const { return bytes_; }

 private:
  void append_varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>(value | 0x80);
    bytes_ += static_cast<char>(value);
  }

  std::string bytes_;
};

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
enum NodeField : std::uint32_t { node_input = 1, node_output = 2, node_name = 3, node_type = 4, node_attribute = 5 };
enum AttributeField : std::uint32_t { attribute_name = 1, attribute_i = 3, attribute_ints = 8, attribute_type = 20 };
enum AttributeType : std::uint64_t { type_int = 2, type_ints = 7 };
enum TensorField : std::uint32_t { tensor_dims = 1, tensor_type = 2, tensor_name = 8, tensor_raw = 9 };
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
