#include "client/station/guide_link.h"

#include <utility>

#include "common/dds/topics.h"

namespace palpate {

GuideLink::GuideLink(int domain, const dds::Network& network, std::string station)
    : station_(std::move(station)),
      service_(dds::Participant::Service(domain, network)),
      targets_(service_, dds::kGuideTopic, dds::Qos::kStream) {}

}  // namespace palpate
