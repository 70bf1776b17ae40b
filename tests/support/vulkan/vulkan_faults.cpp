// The record of objects and the installation of the hooks. See vulkan_faults.h.
#include "tests/support/vulkan/vulkan_faults.h"

#include <gtest/gtest.h>

namespace tests {

VulkanFaults* VulkanFaults::current = nullptr;

void ObjectBook::made(std::string_view type, uint64_t handle, uint64_t parent)
{
    const std::lock_guard lock(mutex_);
    alive_[{std::string(type), handle}] = parent;
}

void ObjectBook::destroyed(std::string_view type, uint64_t handle, uint64_t parent)
{
    if (handle == 0) return;
    const std::lock_guard lock(mutex_);
    const auto entry = alive_.find({std::string(type), handle});
    if (entry == alive_.end()) {
        // Objects of devices that existed before the guard are not recorded.
        if (alive_.contains({"Device", parent}))
            complaints_ += "destroyed, but not alive: " + std::string(type) + '\n';
        return;
    }
    alive_.erase(entry);
    if (type != "Device") return;
    for (const auto& [object, owner] : alive_) {
        if (owner == handle) complaints_ += "outlives its device: " + object.first + '\n';
    }
}

std::string ObjectBook::complaints() const
{
    const std::lock_guard lock(mutex_);
    std::string text = complaints_;
    for (const auto& [object, owner] : alive_) text += "still alive: " + object.first + '\n';
    return text;
}

size_t ObjectBook::alive(std::string_view type) const
{
    const std::lock_guard lock(mutex_);
    size_t count = 0;
    for (const auto& [object, owner] : alive_) count += object.first == type ? 1u : 0u;
    return count;
}

VulkanFaults::VulkanFaults() : before_(gpu::vk)
{
    if (current != nullptr) ADD_FAILURE() << "one guard at a time";
    current = this;
#define TESTS_INSTALL(name) Hook<&gpu::Api::name>::install(gpu::vk.name, #name);
    REKINDLE_VULKAN_FUNCTIONS(TESTS_INSTALL)
#undef TESTS_INSTALL
}

VulkanFaults::~VulkanFaults()
{
    gpu::vk = before_;
    current = nullptr;
}

void VulkanFaults::failAny(VkResult result, uint64_t k)
{
    const std::lock_guard lock(mutex_);
    plans_.push_back({nullptr, k, 1, result, {}});
}

void VulkanFaults::interruptAny(std::function<void()> action, uint64_t k)
{
    const std::lock_guard lock(mutex_);
    plans_.push_back({nullptr, k, 1, VK_SUCCESS, std::move(action)});
}

std::optional<VkResult> VulkanFaults::nextFault(const char* entry)
{
    ++failable_;
    std::function<void()> instead;
    std::optional<VkResult> result;
    {
        const std::lock_guard lock(mutex_);
        for (PlannedFault& plan : plans_) {
            if (plan.entry != nullptr && std::string_view(plan.entry) != entry) continue;
            const bool waits = std::string_view(entry) == "WaitForFences";
            if (plan.entry == nullptr && waits && plan.result != VK_ERROR_DEVICE_LOST) continue;
            const uint64_t call = plan.seen++;
            if (call < plan.first || call - plan.first >= plan.times || result) continue;
            ++plan.struck;
            result = plan.result;
            instead = plan.instead;
        }
    }
    if (!instead) return result;
    instead();
    return std::nullopt;
}

uint64_t VulkanFaults::struck() const
{
    const std::lock_guard lock(mutex_);
    uint64_t sum = 0;
    for (const PlannedFault& plan : plans_) sum += plan.struck;
    return sum;
}

void VulkanFaults::clearPlans()
{
    const std::lock_guard lock(mutex_);
    plans_.clear();
}

}  // namespace tests
