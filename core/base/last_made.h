// A slot for something that is dear to make and that several threads want: the first who asks for a
// key makes it, from what was there before if that helps; the others get the same object.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace core {

/// Holds the value that was made last, and the key that it was made for.
template <class Key, class T> class LastMade {
public:
    struct Entry {
        Key key;
        std::shared_ptr<const T> value;
    };

    /// The value if it is there for this key, else null. Does not wait for one who makes it.
    template <class IsKey> std::shared_ptr<const T> find(const IsKey& isKey) const
    {
        const Entry entry = last();
        return entry.value && isKey(entry.key) ? entry.value : nullptr;
    }

    /// The value for `key`, made by `make(previous value or null)` when it is not there. Callers
    /// queue up meanwhile. What `make` throws is passed on, and the next in the queue tries again.
    template <class IsKey, class Make>
    std::shared_ptr<const T> get(const Key& key, const IsKey& isKey, const Make& make)
    {
        const std::lock_guard oneMaker(making_);
        const Entry entry = last();
        if (entry.value && isKey(entry.key)) return entry.value;
        Entry made{key, make(entry.value)};
        const std::lock_guard lock(mutex_);
        last_ = std::move(made);
        return last_.value;
    }

private:
    Entry last() const
    {
        const std::lock_guard lock(mutex_);
        return last_;
    }

    std::mutex making_;
    mutable std::mutex mutex_;
    Entry last_;
};

}  // namespace core
