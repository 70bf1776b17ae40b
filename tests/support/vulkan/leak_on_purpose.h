// Where the program must not free: what a device may still use after it was given up.
#pragma once

extern "C" __attribute__((weak)) void __lsan_disable();
extern "C" __attribute__((weak)) void __lsan_enable();

namespace tests {

/// While it lives, LeakSanitizer (if there is one) takes what this thread allocates for kept.
struct LeakOnPurpose {
    LeakOnPurpose()
    {
        if (__lsan_disable != nullptr) __lsan_disable();
    }
    ~LeakOnPurpose()
    {
        if (__lsan_enable != nullptr) __lsan_enable();
    }
    LeakOnPurpose(const LeakOnPurpose&) = delete;
    LeakOnPurpose& operator=(const LeakOnPurpose&) = delete;
};

}  // namespace tests
