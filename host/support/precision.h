// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

namespace tactel::host {

/// Precision of the arithmetic in kernels.
enum class Precision { fp32, fp64 };

/// The precision of a number's type.
template <class Real>
inline constexpr Precision precision_of = sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64;

/// Returns "fp32" or "fp64".
inline const char* name(Precision precision) { return precision == Precision::fp32 ? "fp32" : "fp64"; }
/// Returns the precision of that name; of an empty one `usual`.
inline Precision precision_named(std::string_view name, Precision usual = Precision::fp32) {
  return name.empty() ? usual : name == "fp64" ? Precision::fp64 : Precision::fp32;
}
/// Calls function.operator()<float>() or <double>(), as the precision asks.
template <class Function>
auto in_precision(Precision precision, const Function& function) {
  return precision == Precision::fp32 ? function.template operator()<float>() : function.template operator()<double>();
}
/// Returns the OpenCL C type, for -DREAL=: "float" or "double".
inline const char* real_type(Precision precision) { return precision == Precision::fp32 ? "float" : "double"; }

}  // namespace tactel::host
