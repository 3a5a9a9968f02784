// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <google/protobuf/message.h>
#include <onnx/onnx_pb.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "host/support/checksum.h"
#include "nn/infer/network_file.h"

// Network files as libprotobuf sees them, which the program does not use.
namespace tactel::tests {

inline onnx::ModelProto parsed(const nn::Model& model) {
  onnx::ModelProto proto;
  if (!proto.ParseFromString(infer::network_bytes(model))) throw std::logic_error("no protobuf");
  return proto;
}

/// An entry of the metadata.
inline std::string& metadata(onnx::ModelProto& proto, std::string_view key) {
  for (onnx::StringStringEntryProto& entry : *proto.mutable_metadata_props())
    if (entry.key() == key) return *entry.mutable_value();
  throw std::logic_error("no metadata " + std::string(key));
}

inline onnx::TensorProto& initializer(onnx::ModelProto& proto, const std::string& name) {
  for (onnx::TensorProto& tensor : *proto.mutable_graph()->mutable_initializer())
    if (tensor.name() == name) return tensor;
  throw std::logic_error("no initializer " + name);
}

/// Puts another number in the place of a tensor's first one.
inline void begin_with(onnx::TensorProto& tensor, float number) {
  tensor.mutable_raw_data()->replace(0, sizeof number, reinterpret_cast<const char*>(&number), sizeof number);
}

/// The checksum of a file's content: of names, types, dimensions and numbers of the initializers, then of the metadata
/// but for the checksum, sorted. Texts follow their lengths.
inline std::string content_checksum(const onnx::ModelProto& proto) {
  std::string all;
  const auto add_number = [&all](std::int64_t number) {
    all.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  const auto add_text = [&](std::string_view text) {
    add_number(static_cast<std::int64_t>(text.size()));
    all.append(text);
  };
  for (const onnx::TensorProto& tensor : proto.graph().initializer()) {
    add_text(tensor.name());
    add_number(tensor.data_type());
    add_number(tensor.dims_size());
    for (const std::int64_t extent : tensor.dims()) add_number(extent);
    add_text(tensor.raw_data());
  }
  std::map<std::string_view, std::string_view> entries;
  for (const onnx::StringStringEntryProto& entry : proto.metadata_props()) entries[entry.key()] = entry.value();
  entries.erase("checksum");
  for (const auto& [key, value] : entries) add_text(key), add_text(value);
  return host::checksum_text(all);
}

/// The bytes of a changed file under the checksum that its content then has: no checksum keeps it out.
inline std::string sealed(onnx::ModelProto proto) {
  const std::string sum = content_checksum(proto);
  for (onnx::StringStringEntryProto& entry : *proto.mutable_metadata_props())
    if (entry.key() == "checksum") entry.set_value(sum);
  return proto.SerializePartialAsString();
}

/// Makes every small change of a message and those within, one at a time: calls `look` with its place and kind, while
/// the change is there. Fields are taken away, changed, doubled, or given where there is none; one is unknown to ONNX.
inline void each_change(google::protobuf::Message& message, const std::string& place,
                        const std::function<void(const std::string&)>& look) {
  using google::protobuf::FieldDescriptor;
  const google::protobuf::Reflection& access = *message.GetReflection();
  const std::unique_ptr<google::protobuf::Message> before(message.New());
  before->CopyFrom(message);
  const auto with = [&](const std::string& what, const auto& change) {
    change();
    look(place + ": " + what);
    message.CopyFrom(*before);
  };
  with("unknown field", [&] { access.MutableUnknownFields(&message)->AddVarint(1000, 1); });
  const auto* const description = message.GetDescriptor();
  for (int k = 0; k < description->field_count(); ++k) {
    const FieldDescriptor* field = description->field(k);
    const auto add_or_change = [&] {
      const bool add = field->is_repeated();
      switch (field->cpp_type()) {
        case FieldDescriptor::CPPTYPE_STRING:
          add ? access.AddString(&message, field, "x")
              : access.SetString(&message, field, access.GetString(message, field) + "x");
          return;
        case FieldDescriptor::CPPTYPE_INT64:
          add ? access.AddInt64(&message, field, 1)
              : access.SetInt64(&message, field, access.GetInt64(message, field) + 1);
          return;
        case FieldDescriptor::CPPTYPE_INT32:
          add ? access.AddInt32(&message, field, 1)
              : access.SetInt32(&message, field, access.GetInt32(message, field) + 1);
          return;
        case FieldDescriptor::CPPTYPE_UINT64:
          add ? access.AddUInt64(&message, field, 1) : access.SetUInt64(&message, field, 1);
          return;
        case FieldDescriptor::CPPTYPE_FLOAT:
          add ? access.AddFloat(&message, field, 1) : access.SetFloat(&message, field, 1);
          return;
        case FieldDescriptor::CPPTYPE_DOUBLE:
          add ? access.AddDouble(&message, field, 1) : access.SetDouble(&message, field, 1);
          return;
        case FieldDescriptor::CPPTYPE_ENUM:
          access.SetEnumValue(&message, field, access.GetEnumValue(message, field) == 1 ? 3 : 1);
          return;
        case FieldDescriptor::CPPTYPE_MESSAGE:
          if (add) access.AddMessage(&message, field);
          if (!add && !access.HasField(message, field)) access.MutableMessage(&message, field);
          return;
        default:
          throw std::logic_error("a field of another type");
      }
    };
    const bool given = field->is_repeated() ? access.FieldSize(message, field) > 0 : access.HasField(message, field);
    if (given && field->is_repeated()) {
      with(field->name() + " less", [&] { access.RemoveLast(&message, field); });
      if (access.FieldSize(message, field) > 1)
        with(field->name() + " in another order",
             [&] { access.SwapElements(&message, field, 0, access.FieldSize(message, field) - 1); });
    } else if (given) {
      with(field->name() + " missing", [&] { access.ClearField(&message, field); });
    }
    if (!given || field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE)
      with(field->name() + " more", add_or_change);
  }
  for (int k = 0; k < description->field_count(); ++k) {
    const FieldDescriptor* field = description->field(k);
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated() && access.HasField(message, field))
      each_change(*access.MutableMessage(&message, field), place + "." + field->name(), look);
    for (int i = 0; field->is_repeated() && i < access.FieldSize(message, field); ++i)
      each_change(*access.MutableRepeatedMessage(&message, field, i),
                  place + "." + field->name() + "[" + std::to_string(i) + "]", look);
  }
}

}  // namespace tactel::tests
