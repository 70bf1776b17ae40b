// See output_file.h.
#include "core/base/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "core/base/check.h"

namespace core {

namespace fs = std::filesystem;

namespace {

/// What a name leads to.
struct Target {
    fs::path file;                  // no link
    std::optional<int> descriptor;  // of this process: /dev/fd/N
    fs::file_type type = fs::file_type::none;

    bool inPlace() const
    {
        return descriptor || type == fs::file_type::character || type == fs::file_type::fifo;
    }
};

std::optional<int> descriptorOf(const fs::path& file)
{
    const std::string name = file.string();
    for (const std::string_view folder : {"/proc/self/fd/", "/dev/fd/"}) {
        if (!name.starts_with(folder)) continue;
        int number = 0;
        const char *begin = name.data() + folder.size(), *end = name.data() + name.size();
        const auto [rest, error] = std::from_chars(begin, end, number);
        if (error == std::errc() && rest == end && number >= 0) return number;
    }
    return {};
}

Target resolve(fs::path file)
{
    std::error_code ignored;
    for (int links = 0; links < 40; ++links) {  // as many as the system follows
        if (const auto descriptor = descriptorOf(file)) return {file, descriptor, {}};
        const fs::file_type type = fs::symlink_status(file, ignored).type();
        if (type != fs::file_type::symlink) return {file, {}, type};
        const fs::path next = fs::read_symlink(file, ignored);
        file = next.is_absolute() ? next : file.parent_path() / next;
    }
    return {file, {}, fs::file_type::symlink};
}

std::string systemText()
{
    return errno != 0 ? std::strerror(errno) : "the folder or the disk refuses it";
}

[[noreturn]] void fail(const fs::path& file, const std::string& reason)
{
    throw Error(file.string() + ": cannot be written: " + reason);
}

class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor()
    {
        if (number_ >= 0) ::close(number_);
    }

    bool valid() const { return number_ >= 0; }

    bool write(std::span<const std::byte> bytes)
    {
        while (!bytes.empty()) {
            const ssize_t count = ::write(number_, bytes.data(), bytes.size());
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) return false;
            bytes = bytes.subspan(static_cast<size_t>(count));
        }
        return true;
    }

    /// Some file systems report a full disk or a quota only here.
    bool close() { return ::close(std::exchange(number_, -1)) == 0; }

private:
    int number_;
};

void writeInPlace(const fs::path& file, const Target& target, std::span<const std::byte> bytes)
{
    errno = 0;
    Descriptor out(target.descriptor ? ::dup(*target.descriptor)
                                     : ::open(target.file.c_str(), O_WRONLY | O_CLOEXEC));
    if (!out.valid() || !out.write(bytes) || !out.close()) fail(file, systemText());
}

/// In the folder of the file; no other process or thread uses it.
fs::path temporaryName(const fs::path& file)
{
    static std::atomic<uint32_t> counter{0};
    std::string name(1, '.');
    name.append(file.filename().string()).append(1, '.');
    name.append(std::to_string(::getpid())).append(1, '-').append(std::to_string(counter++));
    name.append(".tmp");
    return file.parent_path() / name;
}

int create(const fs::path& file)
{
    errno = 0;
    return ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

/// Checks what can be seen before writing.
void requireWritableTarget(const fs::path& file, const Target& target)
{
    switch (target.type) {
    case fs::file_type::directory:
        throw Error(file.string() + ": is a folder — name a file");
    case fs::file_type::symlink:
        fail(file, "its links lead in a circle");
    case fs::file_type::none:
    case fs::file_type::regular:
    case fs::file_type::not_found:
    case fs::file_type::character:
    case fs::file_type::fifo:
        return;
    default:
        fail(file, "is neither a file nor a pipe");
    }
}

}  // namespace

void writeFile(const fs::path& file, std::span<const std::byte> bytes)
{
    const Target target = resolve(file);
    requireWritableTarget(file, target);
    if (target.inPlace()) return writeInPlace(file, target, bytes);
    const fs::path temporary = temporaryName(target.file);
    Descriptor out(create(temporary));
    std::error_code error, ignored;
    if (!out.valid()) fail(file, systemText());
    if (!out.write(bytes) || !out.close()) {
        const std::string reason = systemText();
        fs::remove(temporary, ignored);
        fail(file, reason);
    }
    fs::rename(temporary, target.file, error);
    if (!error) return;
    fs::remove(temporary, ignored);
    fail(file, error.message());
}

void writeFile(const fs::path& file, std::string_view text)
{
    writeFile(file, std::as_bytes(std::span(text)));
}

void requireWritableFile(const fs::path& file)
{
    const Target target = resolve(file);
    requireWritableTarget(file, target);
    errno = 0;
    if (target.inPlace()) {
        if (!target.descriptor && ::access(target.file.c_str(), W_OK) != 0)
            fail(file, systemText());
        return;
    }
    std::error_code ignored;
    const fs::path folder = target.file.has_parent_path() ? target.file.parent_path() : ".";
    if (!fs::is_directory(folder, ignored))
        throw Error(file.string() + ": folder " + folder.string() +
                    " does not exist — create it first");
    // Trying is the only test that also sees read-only file systems and quotas.
    const fs::path temporary = temporaryName(target.file);
    Descriptor out(create(temporary));
    const bool fine = out.valid() && out.write(std::as_bytes(std::span(" ", 1)));
    const std::string reason = systemText();
    if (out.valid()) fs::remove(temporary, ignored);
    if (!fine) fail(file, reason);
}

bool sameFile(const fs::path& a, const fs::path& b)
{
    const Target ta = resolve(a), tb = resolve(b);
    if (ta.inPlace() || tb.inPlace()) return false;
    std::error_code ignored;
    const fs::path wholeA = fs::weakly_canonical(fs::absolute(ta.file, ignored), ignored);
    return wholeA == fs::weakly_canonical(fs::absolute(tb.file, ignored), ignored);
}

}  // namespace core
