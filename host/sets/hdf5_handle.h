// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <hdf5.h>

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

namespace tactel::host {

/// An HDF5 handle that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() { close(); }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool open() const { return id_ >= 0; }
  /// Closes the handle. Returns false where the library could not close it: buffered data are then lost.
  bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Call it before any other call of HDF5. Disables the library's own error printing; callers throw ConfigError.
/// Disables the library's clean-up at exit: where a full disk made a close fail, the clean-up repeats it and
/// crashes. Every Handle closes itself, so no clean-up is needed.
inline void prepare_hdf5() {
  static const bool once = H5dont_atexit() >= 0;
  static_cast<void>(once);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// While it lives, files that HDF5 opens are not locked, whatever HDF5_USE_FILE_LOCKING says, which HDF5 reads then:
/// sets are written under names of their own, with locks of their own, and never changed.
class WithoutLocks {
 public:
  WithoutLocks() {
    if (const char* value = std::getenv(name)) users_ = value;
    setenv(name, "FALSE", 1);
  }
  ~WithoutLocks() { users_ ? setenv(name, users_->c_str(), 1) : unsetenv(name); }
  WithoutLocks(const WithoutLocks&) = delete;
  WithoutLocks& operator=(const WithoutLocks&) = delete;

 private:
  static constexpr const char* name = "HDF5_USE_FILE_LOCKING";
  std::optional<std::string> users_;
};

/// Returns the HDF5 type of a number.
template <class T>
hid_t type_of();
template <>
inline hid_t type_of<float>() {
  return H5T_IEEE_F32LE;
}
template <>
inline hid_t type_of<std::uint8_t>() {
  return H5T_STD_U8LE;
}
template <>
inline hid_t type_of<std::uint16_t>() {
  return H5T_STD_U16LE;
}
template <>
inline hid_t type_of<std::uint32_t>() {
  return H5T_STD_U32LE;
}
template <>
inline hid_t type_of<std::uint64_t>() {
  return H5T_STD_U64LE;
}

}  // namespace tactel::host
