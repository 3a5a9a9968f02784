// SPDX-License-Identifier: Apache-2.0
#ifndef TACTEL_EXPORT_H
#define TACTEL_EXPORT_H

/* Marks what the shared libraries of tactel show. */
#if defined(__GNUC__)
#define TACTEL_API __attribute__((visibility("default")))
#else
#define TACTEL_API
#endif

#endif
