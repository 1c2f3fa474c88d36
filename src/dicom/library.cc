/* DCMTK's global state: codecs and logging, set up once; and the small text helpers of this folder.
 * DCMTK's messages may quote attributes of the patient, so none is passed on. One kind is listened to, because nothing
 * else tells it: its decoders fill up what is missing in damaged data, warn, and report success. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdict.h"
#include "dcmtk/dcmdata/dcobject.h"
#include "dcmtk/dcmdata/dcrledrg.h"
#include "dcmtk/dcmdata/dcvr.h"
#include "dcmtk/dcmjpeg/djdecode.h"
#include "dcmtk/dcmjpls/djdecode.h"
#include "dcmtk/oflog/oflog.h"
#include "dcmtk/oflog/spi/logevent.h"

#include "dicom_private.h"

#include <cstdarg>
#include <mutex>

namespace vitdicom {

namespace {

thread_local bool heard_damage;

class Listener : public dcmtk::log4cplus::Appender {
  public:
    ~Listener() override
    {
        destructorImpl();
    }
    void close() override {}

  protected:
    void append(const dcmtk::log4cplus::spi::InternalLoggingEvent &event) override
    {
        /* "extraneous bytes" and odd parameters are bad manners, not missing pixels. */
        const std::string text = event.getMessage().c_str();
        auto has = [&text](const char *part) { return text.find(part) != std::string::npos; };
        if ((has("Corrupt JPEG data") && !has("extraneous")) || has("Premature end") || has("insufficient data"))
            heard_damage = true;
    }
};

void listen()
{
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    dcmtk::log4cplus::Logger root = dcmtk::log4cplus::Logger::getRoot();
    root.removeAllAppenders();
    root.addAppender(dcmtk::log4cplus::SharedAppenderPtr(new Listener));
    root.setLogLevel(OFLogger::WARN_LOG_LEVEL);
}

} // namespace

bool library_heard_damage()
{
    bool heard = heard_damage;
    heard_damage = false;
    return heard;
}

bool library_init(const vit_log *log)
{
    static std::once_flag once;
    std::call_once(once, [] {
        listen();
        dcmEnableUnknownVRConversion.set(OFTrue);        /* attributes written as UN are read as what they are */
        dcmAutoDetectDatasetXfer.set(OFTrue);            /* a meta header that says implicit over explicit, … */
        dcmAcceptUnexpectedImplicitEncoding.set(OFTrue); /* … and elements without a VR amid those that have one */
        DJDecoderRegistration::registerCodecs();
        DJLSDecoderRegistration::registerCodecs();
        DcmRLEDecoderRegistration::registerCodecs();
    });
    if (dcmDataDict.isDictionaryLoaded())
        return true;
    vit_error(log, "dicom: DCMTK has no data dictionary (its dicom.dic is missing); install DCMTK's data files or set "
                   "DCMDICTPATH");
    return false;
}

std::string one_line(const std::string &text)
{
    std::string clean = text;
    for (char &c : clean)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = '?';
    return clean;
}

std::string format(const char *text, ...)
{
    char line[1024];
    va_list arguments;
    va_start(arguments, text);
    vsnprintf(line, sizeof line, text, arguments);
    va_end(arguments);
    return one_line(line);
}

std::string file_name(const std::string &path)
{
    size_t slash = path.find_last_of('/');
    return one_line(slash == std::string::npos ? path : path.substr(slash + 1));
}

namespace {

const char *const warning_ids[] = {
#define X(name, id, help) id,
    VIT_DICOM_WARNINGS(X)
#undef X
};

} // namespace

void warn(Stack &stack, Warning warning, const char *text, ...)
{
    char line[1024];
    va_list arguments;
    va_start(arguments, text);
    vsnprintf(line, sizeof line, text, arguments);
    va_end(arguments);
    stack.warnings.push_back(std::string(warning_ids[size_t(warning)]) + ": " + one_line(line));
}

std::string slice_name(const Slice &slice)
{
    std::string name = file_name(slice.file.path);
    return slice.frame ? name + " frame " + std::to_string(slice.frame) : name;
}

} // namespace vitdicom

extern "C" const struct vit_dicom_warning vit_dicom_warnings[] = {
#define X(name, id, help) {id, help},
    VIT_DICOM_WARNINGS(X)
#undef X
        {nullptr, nullptr},
};
