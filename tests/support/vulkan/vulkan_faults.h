// Faults planted in Vulkan: while a VulkanFaults lives, every entry of gpu::vk goes through a hook
// that can fail a call, put another function in its place, count calls, and record the objects made
// and destroyed.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "app/gpu/base/api.h"

namespace tests {

/// Objects that were made and not yet destroyed, and what was wrong about it.
class ObjectBook {
public:
    void made(std::string_view type, uint64_t handle, uint64_t parent);
    void destroyed(std::string_view type, uint64_t handle, uint64_t parent);

    /// Objects alive, objects that outlived their device, objects destroyed twice: one line each;
    /// empty is good.
    std::string complaints() const;
    size_t alive(std::string_view type) const;

private:
    struct Object {
        std::string type;
        uint64_t parent;
    };
    mutable std::mutex mutex_;
    std::map<std::pair<std::string, uint64_t>, uint64_t> alive_;  // type and handle: parent
    std::string complaints_;
};

/// A call that fails: counted over one entry (`entry` is its hook's name) or over all that return a
/// VkResult.
struct PlannedFault {
    const char* entry = nullptr;  // null: any
    uint64_t first = 0, times = 1;
    VkResult result = VK_SUCCESS;
    std::function<void()> instead;  // throws, for example; else `result` is returned
    uint64_t seen = 0, struck = 0;
};

class VulkanFaults {
public:
    VulkanFaults();
    ~VulkanFaults();
    VulkanFaults(const VulkanFaults&) = delete;
    VulkanFaults& operator=(const VulkanFaults&) = delete;

    /// Calls k, k + 1, ..., k + times - 1 (from 0, counted from now) of Entry give `result` and do
    /// not reach the driver.
    template <auto Entry> void fail(VkResult result, uint64_t k = 0, uint64_t times = 1);

    /// The k-th call from now of anything that returns a VkResult gives `result`. Waits for fences
    /// count only when the device is to be lost: after any other failure it is not known whether
    /// the work has ended.
    void failAny(VkResult result, uint64_t k);

    /// The k-th call from now of anything that returns a VkResult (but waits for fences) does this
    /// first; it may throw.
    void interruptAny(std::function<void()> action, uint64_t k);

    /// Every call of Entry becomes replacement(driver's function, arguments...).
    template <auto Entry, class F> void replace(F replacement);

    template <auto Entry> uint64_t calls() const;

    /// Calls of what returns a VkResult since the guard was made.
    uint64_t failableCalls() const { return failable_; }
    /// How often a planned fault has happened.
    uint64_t struck() const;
    void clearPlans();

    const ObjectBook& objects() const { return objects_; }

    // --- for the hooks
    std::optional<VkResult> nextFault(const char* entry);
    ObjectBook& book() { return objects_; }
    static VulkanFaults* current;

private:
    gpu::Api before_;
    ObjectBook objects_;
    mutable std::mutex mutex_;
    std::vector<PlannedFault> plans_;
    std::atomic<uint64_t> failable_{0};
};

/// The function that stands in the table for Entry.
template <auto Entry,
          class Type = std::remove_reference_t<decltype(std::declval<gpu::Api&>().*Entry)>>
struct Hook;

template <auto Entry, class R, class... A> struct Hook<Entry, R (*)(A...)> {
    using Function = R (*)(A...);
    static inline Function driver = nullptr;
    static inline std::function<R(Function, A...)> replacement;
    static inline const char* name = "";
    static inline std::atomic<uint64_t> calls{0};

    static void install(Function& entry, const char* entryName)
    {
        driver = entry;
        name = entryName;
        replacement = {};
        calls = 0;
        entry = &call;
    }

    static R call(A... arguments)
    {
        ++calls;
        if constexpr (std::is_same_v<R, VkResult>) {
            if (const std::optional<VkResult> fault = VulkanFaults::current->nextFault(name)) {
                // The work itself ends before its loss is told: what it uses may be freed then.
                if (std::string_view(name) == "WaitForFences") driver(arguments...);
                return *fault;
            }
        }
        noteDestroyed(std::tuple<A...>(arguments...));
        if constexpr (std::is_void_v<R>) {
            if (replacement) {
                replacement(driver, arguments...);
            } else {
                driver(arguments...);
            }
        } else {
            const R result = replacement ? replacement(driver, arguments...) : driver(arguments...);
            if constexpr (std::is_same_v<R, VkResult>) {
                if (result == VK_SUCCESS) noteMade(std::tuple<A...>(arguments...));
            }
            return result;
        }
    }

private:
    template <class T> static uint64_t number(T handle)
    {
        if constexpr (std::is_pointer_v<T>) {
            return reinterpret_cast<uint64_t>(handle);
        } else {
            return static_cast<uint64_t>(handle);
        }
    }

    static void noteMade(const std::tuple<A...>& arguments)
    {
        const std::string_view text(name);
        if constexpr (sizeof...(A) >= 3) {
            const auto& last = std::get<sizeof...(A) - 1>(arguments);
            using Last = std::remove_cvref_t<decltype(last)>;
            if constexpr (std::is_pointer_v<Last> &&
                          std::is_pointer_v<std::remove_pointer_t<Last>>) {
                const uint64_t parent =
                    text == "CreateInstance" ? 0 : number(std::get<0>(arguments));
                if (text == "CreateComputePipelines") {
                    if constexpr (sizeof...(A) == 6) {
                        for (uint32_t i = 0; i < std::get<2>(arguments); ++i) {
                            VulkanFaults::current->book().made("Pipeline", number(last[i]), parent);
                        }
                    }
                } else if (text.starts_with("Create")) {
                    VulkanFaults::current->book().made(text.substr(6), number(*last), parent);
                } else if (text == "AllocateMemory") {
                    VulkanFaults::current->book().made("Memory", number(*last), parent);
                }
            }
        }
    }

    static void noteDestroyed(const std::tuple<A...>& arguments)
    {
        const std::string_view text(name);
        if (text == "DestroySurfaceKHR") return;  // GLFW makes surfaces
        const bool destroys = text.starts_with("Destroy");
        if (!destroys && text != "FreeMemory") return;
        const std::string_view type = destroys ? text.substr(7) : "Memory";
        if constexpr (sizeof...(A) == 3) {
            if constexpr (std::is_pointer_v<std::tuple_element_t<1, std::tuple<A...>>>) {
                VulkanFaults::current->book().destroyed(type, number(std::get<1>(arguments)),
                                                        number(std::get<0>(arguments)));
            }
        } else if constexpr (sizeof...(A) == 2) {
            VulkanFaults::current->book().destroyed(type, number(std::get<0>(arguments)), 0);
        }
    }
};

template <auto Entry> void VulkanFaults::fail(VkResult result, uint64_t k, uint64_t times)
{
    const std::lock_guard lock(mutex_);
    plans_.push_back({Hook<Entry>::name, k, times, result, {}});
}

template <auto Entry, class F> void VulkanFaults::replace(F replacement)
{
    Hook<Entry>::replacement = std::move(replacement);
}

template <auto Entry> uint64_t VulkanFaults::calls() const
{
    return Hook<Entry>::calls;
}

}  // namespace tests
