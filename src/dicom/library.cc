/* DCMTK's global state: codecs and logging, set up once; and the small text helpers of this folder. */
#include "dcmtk/config/osconfig.h"

#include "dcmtk/dcmdata/dcdict.h"
#include "dcmtk/dcmdata/dcrledrg.h"
#include "dcmtk/dcmdata/dcvr.h"
#include "dcmtk/dcmjpeg/djdecode.h"
#include "dcmtk/dcmjpls/djdecode.h"
#include "dcmtk/oflog/oflog.h"

#include "dicom_private.h"

#include <cstdarg>
#include <mutex>

namespace vitdicom {

bool library_init(const vit_log *log)
{
    static std::once_flag once;
    std::call_once(once, [] {
        OFLog::configure(OFLogger::OFF_LOG_LEVEL);
        dcmEnableUnknownVRConversion.set(OFTrue); /* attributes written as UN are read as what they are */
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

} // namespace vitdicom
