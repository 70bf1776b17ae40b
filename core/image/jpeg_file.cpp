// See jpeg_file.h. Libjpeg leaves a fault by longjmp: what stands between the jump and its end
// holds nothing that needs a destructor.
#include "core/image/jpeg_file.h"

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>

namespace core {

namespace {

// Encoders write about ten. Each is a run over the whole image, however short it is in the file.
constexpr int kMaxScans = 100;

/// One use of libjpeg, and what its callbacks see.
class Reader {
public:
    Reader(EncodedImage bytes, const std::stop_token& stop) : bytes_(bytes), stop_(stop)
    {
        info_.err = jpeg_std_error(&errors_);
        info_.client_data = this;
        errors_.error_exit = onError;
        errors_.emit_message = onMessage;
        errors_.output_message = [](j_common_ptr) {};
        progress_.progress_monitor = onProgress;
    }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    ~Reader() { jpeg_destroy_decompress(&info_); }

    const char* message() const { return message_.data(); }
    bool damaged() const { return errors_.num_warnings > 0; }

    /// Reads the header, fills `image` but for its pixels and says what the decoder needs beside
    /// them. False: see message().
    bool readHeader(RawImage& image, uint64_t& extraBytes)
    {
        if (setjmp(fault_)) return false;
        jpeg_create_decompress(&info_);
        info_.progress = &progress_;
        jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(bytes_.data()),
                     static_cast<unsigned long>(bytes_.size()));
        jpeg_read_header(&info_, TRUE);
        const int channels = info_.num_components;
        if (channels != 1 && channels != 3 && channels != 4) {
            std::snprintf(message_.data(), message_.size(), "%d colour components", channels);
            return false;
        }
        info_.out_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
        image.width = info_.image_width;
        image.height = info_.image_height;
        image.channels = channels == 1 ? 1 : 3;
        // The coefficients of all scans are kept in blocks of 8 x 8.
        const uint64_t blocks =
            (uint64_t{image.width} + 15) / 8 * ((uint64_t{image.height} + 15) / 8);
        extraBytes = jpeg_has_multiple_scans(&info_)
                         ? blocks * sizeof(JBLOCK) * static_cast<uint64_t>(channels)
                         : 0;
        return true;
    }

    /// False: stopped, or see message(). `ink` holds one row of four channels.
    bool readPixels(RawImage& image, std::vector<unsigned char>& ink)
    {
        if (setjmp(fault_)) return false;
        jpeg_start_decompress(&info_);
        const size_t rowBytes = image.rowBytes();
        while (info_.output_scanline < info_.output_height) {
            checkStop();
            auto* pixels =
                reinterpret_cast<unsigned char*>(&image.pixels[info_.output_scanline * rowBytes]);
            JSAMPROW row = info_.output_components == 4 ? ink.data() : pixels;
            jpeg_read_scanlines(&info_, &row, 1);
            if (info_.output_components == 4) toRgb(ink.data(), pixels);
        }
        return true;
    }

private:
    static Reader& of(j_common_ptr info) { return *static_cast<Reader*>(info->client_data); }

    [[noreturn]] static void onError(j_common_ptr info)
    {
        Reader& reader = of(info);
        std::array<char, JMSG_LENGTH_MAX> text;
        info->err->format_message(info, text.data());
        reader.fail(text.data());
    }

    /// Warnings are counted, traces left out.
    static void onMessage(j_common_ptr info, int level)
    {
        if (level < 0 && info->err->num_warnings++ == 0)
            info->err->format_message(info, of(info).message_.data());
    }

    /// Called now and then while scans are read that give no row yet.
    static void onProgress(j_common_ptr info)
    {
        Reader& reader = of(info);
        reader.checkStop();
        if (reader.info_.input_scan_number > kMaxScans) reader.fail("too many scans");
    }

    void checkStop()
    {
        if (stop_.stop_requested()) fail("stopped");
    }

    [[noreturn]] void fail(const char* text)
    {
        std::snprintf(message_.data(), message_.size(), "%s", text);
        std::longjmp(fault_, 1);
    }

    /// A row of inks; Adobe stores them inverted.
    void toRgb(const unsigned char* ink, unsigned char* rgb) const
    {
        const unsigned flip = info_.saw_Adobe_marker ? 0 : 255;
        for (JDIMENSION x = 0; x < info_.output_width; ++x, ink += 4, rgb += 3)
            for (size_t k = 0; k < 3; ++k)
                rgb[k] =
                    static_cast<unsigned char>(((ink[k] ^ flip) * (ink[3] ^ flip) + 127) / 255);
    }

    EncodedImage bytes_;
    const std::stop_token& stop_;
    jpeg_decompress_struct info_{};
    jpeg_error_mgr errors_{};
    jpeg_progress_mgr progress_{};
    std::jmp_buf fault_{};
    std::array<char, JMSG_LENGTH_MAX> message_{};
};

}  // namespace

bool isJpeg(EncodedImage bytes)
{
    return bytes.size() >= 3 && std::memcmp(bytes.data(), "\xff\xd8\xff", 3) == 0;
}

DecodedImage decodeJpeg(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop)
{
    Reader reader(bytes, stop);
    RawImage image;
    uint64_t extraBytes = 0;
    if (!reader.readHeader(image, extraBytes))
        return {{}, std::string("is damaged: ") + reader.message(), {}};
    if (std::string problem = sizeProblem(image.width, image.height, guards); !problem.empty())
        return {{}, problem, {}};
    if (std::string problem = allocatePixels(image, bytes.size(), extraBytes, guards);
        !problem.empty())
        return {{}, problem, {}};
    std::vector<unsigned char> ink(4 * size_t{image.width});
    if (!reader.readPixels(image, ink)) {
        if (stop.stop_requested()) return {{}, "was not read: loading was stopped", {}};
        return {{}, std::string("is damaged: ") + reader.message(), {}};
    }
    return {std::move(image), {}, reader.damaged() ? reader.message() : ""};
}

}  // namespace core
