// See png_file.h. Libpng leaves a fault by longjmp: what it calls, and what stands between the jump
// and its end, holds nothing that needs a destructor.
#include "core/image/png_file.h"

#include <bit>
#include <csetjmp>
#include <cstring>
#include <optional>

#include <png.h>

#include "core/base/check.h"

namespace core {

namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
// What libpng knows and a texture does not need; most of it is compressed or parsed. What it does
// not know it passes over.
constexpr png_byte kLeftOut[] = "bKGD\0cHRM\0eXIf\0gAMA\0hIST\0iCCP\0iTXt\0oFFs\0pCAL\0pHYs\0sBIT\0"
                                "sCAL\0sPLT\0sTER\0sRGB\0tEXt\0tIME\0zTXt";

constexpr uint32_t kHeader = 0x49484452, kEnd = 0x49454e44, kText = 0x74455874;

uint32_t word(EncodedImage bytes, size_t at)
{
    uint32_t value = 0;
    for (size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<uint32_t>(bytes[at + k]);
    return value;
}

struct Chunk {
    uint32_t type = 0;
    EncodedImage content;
};

/// The chunks in their order. next() is empty behind the last whole one.
class Chunks {
public:
    explicit Chunks(EncodedImage bytes) : bytes_(bytes), at_(kSignature.size()) {}

    std::optional<Chunk> next()
    {
        constexpr size_t kFrame = 12;  // length, type and checksum
        if (at_ + kFrame > bytes_.size()) return {};
        const uint64_t length = word(bytes_, at_);
        if (length > bytes_.size() - at_ - kFrame) return {};
        const Chunk chunk{word(bytes_, at_ + 4), bytes_.subspan(at_ + 8, length)};
        at_ += kFrame + length;
        return chunk;
    }

private:
    EncodedImage bytes_;
    size_t at_;
};

/// Says what is wrong with the sequence of chunks, so that a file which was cut off is refused
/// before its pixels are allocated.
std::string problemOf(EncodedImage bytes, const ImageGuards& guards)
{
    Chunks chunks(bytes);
    std::optional<Chunk> chunk = chunks.next();
    if (!chunk || chunk->type != kHeader || chunk->content.size() != 13)
        return "is damaged: no header";
    if (std::string problem = sizeProblem(word(chunk->content, 0), word(chunk->content, 4), guards);
        !problem.empty())
        return problem;
    while (chunk && chunk->type != kEnd) chunk = chunks.next();
    if (chunk) return {};
    return "is damaged: cut off after " + std::to_string(bytes.size()) + " bytes";
}

/// One use of libpng, and what its callbacks see.
class Reader {
public:
    explicit Reader(EncodedImage bytes)
        : rest_(bytes),
          png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, onError, onWarning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr)
    {}
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }

    const std::string& message() const { return message_; }

    /// Reads up to the first pixel and fills `image` but for its pixels. False: see message().
    bool readHeader(RawImage& image)
    {
        if (!info_) return false;
        if (setjmp(png_jmpbuf(png_))) return false;
        png_set_read_fn(png_, this, onRead);
        png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, kLeftOut,
                                    static_cast<int>(sizeof(kLeftOut) / 5));
        png_read_info(png_, info_);
        png_set_expand(png_);
        if (std::endian::native == std::endian::little) png_set_swap(png_);
        passes_ = png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        image.width = png_get_image_width(png_, info_);
        image.height = png_get_image_height(png_, info_);
        image.channels = png_get_channels(png_, info_);
        image.type = png_get_bit_depth(png_, info_) == 16 ? RawImage::Type::unsigned16
                                                          : RawImage::Type::unsigned8;
        return png_get_rowbytes(png_, info_) == image.rowBytes();
    }

    /// False: stopped, or see message().
    bool readPixels(RawImage& image, const std::stop_token& stop)
    {
        if (setjmp(png_jmpbuf(png_))) return false;
        const size_t rowBytes = image.rowBytes();
        for (int pass = 0; pass < passes_; ++pass)
            for (uint32_t y = 0; y < image.height; ++y) {
                if (stop.stop_requested()) return false;
                png_read_row(png_, reinterpret_cast<png_bytep>(&image.pixels[y * rowBytes]),
                             nullptr);
            }
        return true;
    }

private:
    [[noreturn]] static void onError(png_structp png, png_const_charp text)
    {
        static_cast<Reader*>(png_get_error_ptr(png))->message_ = text;
        png_longjmp(png, 1);
    }

    static void onWarning(png_structp, png_const_charp) {}

    static void onRead(png_structp png, png_bytep to, size_t count)
    {
        EncodedImage& rest = static_cast<Reader*>(png_get_io_ptr(png))->rest_;
        if (count > rest.size()) png_error(png, "cut off");
        std::memcpy(to, rest.data(), count);
        rest = rest.subspan(count);
    }

    EncodedImage rest_;
    png_structp png_;
    png_infop info_;
    int passes_ = 1;
    std::string message_ = "libpng cannot be used";
};

/// One use of libpng for writing, and what its callbacks see.
class Writer {
public:
    explicit Writer(const std::map<std::string, std::string>& texts)
        : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, onError, onWarning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr)
    {
        for (const auto& [key, value] : texts) {
            png_text entry{};
            entry.compression = PNG_TEXT_COMPRESSION_NONE;
            entry.key = const_cast<png_charp>(key.c_str());  // libpng copies them
            entry.text = const_cast<png_charp>(value.c_str());
            entry.text_length = value.size();
            texts_.push_back(entry);
        }
    }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;
    ~Writer() { png_destroy_write_struct(&png_, &info_); }

    const std::string& message() const { return message_; }
    std::vector<std::byte>& bytes() { return bytes_; }

    /// False: see message().
    bool write(uint32_t width, uint32_t height, uint32_t channels, const uint8_t* pixels)
    {
        static constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                         PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
        if (!info_) return false;
        if (setjmp(png_jmpbuf(png_))) return false;
        png_set_write_fn(png_, this, onWrite, nullptr);
        png_set_IHDR(png_, info_, width, height, 8, kTypes[channels - 1], PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
        if (!texts_.empty())
            png_set_text(png_, info_, texts_.data(), static_cast<int>(texts_.size()));
        png_write_info(png_, info_);
        const size_t rowBytes = size_t{width} * channels;
        for (uint32_t y = 0; y < height; ++y) png_write_row(png_, pixels + y * rowBytes);
        png_write_end(png_, nullptr);
        return true;
    }

private:
    [[noreturn]] static void onError(png_structp png, png_const_charp text)
    {
        static_cast<Writer*>(png_get_error_ptr(png))->message_ = text;
        png_longjmp(png, 1);
    }

    static void onWarning(png_structp, png_const_charp) {}

    static void onWrite(png_structp png, png_bytep from, size_t count)
    {
        if (!static_cast<Writer*>(png_get_io_ptr(png))->append(from, count))
            png_error(png, "there is not enough memory");
    }

    /// No exception may pass through libpng.
    bool append(const png_byte* from, size_t count) noexcept
    {
        try {
            const auto* first = reinterpret_cast<const std::byte*>(from);
            bytes_.insert(bytes_.end(), first, first + count);
            return true;
        } catch (const std::bad_alloc&) {
            return false;
        }
    }

    std::vector<std::byte> bytes_;
    std::vector<png_text> texts_;
    png_structp png_;
    png_infop info_;
    std::string message_ = "libpng cannot be used";
};

}  // namespace

bool isPng(EncodedImage bytes)
{
    return bytes.size() >= kSignature.size() &&
           std::memcmp(bytes.data(), kSignature.data(), kSignature.size()) == 0;
}

DecodedImage decodePng(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop)
{
    if (!isPng(bytes)) return {{}, "is no PNG", {}};
    if (std::string problem = problemOf(bytes, guards); !problem.empty()) return {{}, problem, {}};
    Reader reader(bytes);
    RawImage image;
    if (!reader.readHeader(image)) return {{}, "is damaged: " + reader.message(), {}};
    if (std::string problem = allocatePixels(image, bytes.size(), 0, guards); !problem.empty())
        return {{}, problem, {}};
    if (!reader.readPixels(image, stop)) {
        if (stop.stop_requested()) return {{}, "was not read: loading was stopped", {}};
        return {{}, "is damaged: " + reader.message(), {}};
    }
    return {std::move(image), {}, {}};
}

std::vector<std::byte> encodePng(const std::string& name, uint32_t width, uint32_t height,
                                 uint32_t channels, std::span<const uint8_t> pixels,
                                 const std::map<std::string, std::string>& texts)
{
    CHECK(width > 0 && height > 0 && channels >= 1 && channels <= 4);
    CHECK(pixels.size() == size_t{width} * height * channels);
    Writer writer(texts);
    if (!writer.write(width, height, channels, pixels.data()))
        throw Error(name + ": cannot be written as PNG: " + writer.message(), ExitCode::failure);
    return std::move(writer.bytes());
}

std::string encodeGreyPng(uint32_t width, const std::vector<uint8_t>& pixels)
{
    CHECK(width > 0 && !pixels.empty() && pixels.size() % width == 0);
    const std::vector<std::byte> bytes =
        encodePng("a picture", width, static_cast<uint32_t>(pixels.size() / width), 1, pixels);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::map<std::string, std::string> pngText(EncodedImage bytes)
{
    std::map<std::string, std::string> texts;
    if (!isPng(bytes)) return texts;
    Chunks chunks(bytes);
    for (auto chunk = chunks.next(); chunk && chunk->type != kEnd; chunk = chunks.next()) {
        if (chunk->type != kText) continue;
        const std::string_view content(reinterpret_cast<const char*>(chunk->content.data()),
                                       chunk->content.size());
        const size_t end = content.find('\0');
        if (end != std::string_view::npos)
            texts.emplace(content.substr(0, end), content.substr(end + 1));
    }
    return texts;
}

}  // namespace core
