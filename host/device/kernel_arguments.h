// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "host/device/buffer.h"

namespace tactel::host {

/// A parameter of a kernel as its source declares it.
struct KernelParameter {
  std::string type;  ///< "float", "uint", ... or a struct's name; of a pointer, the type that it points to
  bool pointer = false;
  std::string name;
};

/// Returns the parameters of a kernel in a source; none where the source lacks the kernel. `real`: the type of
/// REAL, "float" or "double". A vector is listed as its element type.
std::vector<KernelParameter> kernel_parameters(std::string_view source, std::string_view kernel, std::string_view real);

/// Returns true where a launch of `kernel` with first_group = NO_GROUPS does nothing: its text has TAKE_GROUP
/// (kernels/shared/group.h).
bool takes_group(std::string_view source, std::string_view kernel);

/// Returns the OpenCL C name of a number's type; "" for a struct.
template <class Value>
constexpr std::string_view kernel_type() {
  constexpr std::string_view names[2][4] = {{"uchar", "ushort", "uint", "ulong"}, {"char", "short", "int", "long"}};
  if (std::is_same_v<Value, float>) return "float";
  if (std::is_same_v<Value, double>) return "double";
  return std::is_integral_v<Value> ? names[std::is_signed_v<Value>][std::bit_width(sizeof(Value)) - 1] : "";
}

/// Sets the arguments of a kernel object by name, or by index from 0. Throws std::logic_error (a mistake in the
/// code) for an unknown name, and for a number whose type differs from the declared one. OpenCL itself checks only
/// sizes, also those of structs.
class KernelArguments {
 public:
  KernelArguments(cl::Kernel& kernel, std::span<const KernelParameter> parameters)
      : kernel_(kernel), parameters_(parameters) {}

  template <class Value>
  void set(unsigned index, const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value> && !std::is_pointer_v<Value>);
    check(index, kernel_type<Value>(), false);
    set_bytes(index, &value, sizeof value);
  }
  template <class T>
  void set(unsigned index, const Buffer<T>& buffer) {
    check(index, kernel_type<T>(), true);
    set_buffer(index, buffer.cl_buffer());
  }
  template <class Value>
  void set(std::string_view name, const Value& value) {
    set(place(name), value);
  }

 private:
  unsigned place(std::string_view name) const;
  void check(unsigned index, std::string_view type, bool pointer) const;
  void set_bytes(unsigned index, const void* value, std::size_t size);
  void set_buffer(unsigned index, const cl::Buffer& buffer);

  cl::Kernel& kernel_;
  std::span<const KernelParameter> parameters_;
};

}  // namespace tactel::host
