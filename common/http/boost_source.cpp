// The code of Asio and Beast that is no template, compiled once and not in each file that uses HTTP
// or WebSockets.  (TLS is in client/viewer/web_stream.cpp, its only user.)
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
