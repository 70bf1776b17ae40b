// An immutable array whose copies share one storage: what two snapshots have in common exists once,
// and whether it is the same is one comparison of pointers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace core {

template <class T> class SharedArray {
public:
    using value_type = T;

    SharedArray() = default;

    /// Takes over the values; not explicit, so that a builder hands over the vector that it filled.
    SharedArray(std::vector<T> values)
    {
        if (values.empty()) return;
        auto owner = std::make_shared<const std::vector<T>>(std::move(values));
        size_ = owner->size();
        const T* first = owner->data();
        first_ = {std::move(owner), first};
    }

    const T* data() const { return first_.get(); }
    size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const T& operator[](size_t i) const { return data()[i]; }
    const T& front() const { return *data(); }
    const T& back() const { return data()[size_ - 1]; }
    const T* begin() const { return data(); }
    const T* end() const { return data() + size_; }

    /// A copy to change.
    std::vector<T> toVector() const { return {begin(), end()}; }

    /// Whether both are one storage (or both empty): equal without looking.
    bool sharesWith(const SharedArray& other) const
    {
        return first_ == other.first_ && size_ == other.size_;
    }

    /// By value.
    friend bool operator==(const SharedArray& a, const SharedArray& b)
    {
        return a.sharesWith(b) || std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

private:
    std::shared_ptr<const T> first_;  // of a vector, which it keeps alive
    size_t size_ = 0;
};

}  // namespace core
