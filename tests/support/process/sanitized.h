// REKINDLE_SANITIZED: whether this is a build under AddressSanitizer or ThreadSanitizer, which GCC
// and clang say in different ways.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define REKINDLE_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define REKINDLE_SANITIZED
#endif
#endif
