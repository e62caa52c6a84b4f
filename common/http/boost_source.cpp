// What of Asio and Beast is no template, compiled once, in place of in each file that speaks HTTP
// or WebSockets.  (TLS is in client/viewer/web_stream.cpp, its only user.)
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
