// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/error.h>

#include <cstdint>

namespace tactel {

/// Refers to a function bool(std::uint64_t done, std::uint64_t all) that is called from time to time in the calling
/// thread; false cancels. The function must outlive the call that takes it.
class ProgressFunction {
 public:
  ProgressFunction() = default;
  template <class Function>
  ProgressFunction(const Function& function)
      : function_(&function), call_([](const void* f, std::uint64_t done, std::uint64_t all) {
          return static_cast<bool>((*static_cast<const Function*>(f))(done, all));
        }) {}

  /// Returns false where the function cancels.
  bool operator()(std::uint64_t done, std::uint64_t all) const { return !call_ || call_(function_, done, all); }

 private:
  const void* function_ = nullptr;
  bool (*call_)(const void*, std::uint64_t, std::uint64_t) = nullptr;
};

/// While it lives, long calls of this library that its thread makes end by Cancelled soon after asked(with) returns
/// true. Threads that help them call it, too. Of two scopes the inner one counts.
class TACTEL_API CancelScope {
 public:
  CancelScope(bool (*asked)(void*), void* with);
  ~CancelScope();
  CancelScope(const CancelScope&) = delete;
  CancelScope& operator=(const CancelScope&) = delete;

 private:
  struct State;
  State* state_;
};

/// Thrown where a progress function or a CancelScope cancelled.
class TACTEL_API Cancelled : public Error {
 public:
  using Error::Error;
  ~Cancelled() override;
};

/// No OpenCL device, a kernel that it cannot compile, or a sensor that cannot be used.
class TACTEL_API HardwareError : public Error {
 public:
  using Error::Error;
  ~HardwareError() override;
};

}  // namespace tactel
