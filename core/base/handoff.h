// Tells ThreadSanitizer what it cannot see: work handed to TBB's threads, by us or by Embree,
// begins after the handover. In other builds these functions do nothing.
#pragma once

#if defined(__SANITIZE_THREAD__) || defined(REKINDLE_TSAN)
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
#define REKINDLE_SEEN(call) call
#else
#define REKINDLE_SEEN(call) ((void)0)
#endif

namespace core {

/// Whatever was done before a happensBefore() of a handoff is visible after its happensAfter().
struct Handoff {
    void happensBefore() { REKINDLE_SEEN(__tsan_release(this)); }
    void happensAfter() { REKINDLE_SEEN(__tsan_acquire(this)); }
};

}  // namespace core
#undef REKINDLE_SEEN
