// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel {

/// What the error says with which `call` ends; "no error" where it ends well.
template <class Error, class Call>
std::string thrown_message(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace tactel
