#pragma once

/// A wrong comment: a test checks that building the pages reports it.
/// @param nowhere  a parameter that does not exist.
void SaysWhatIsNot(int number);
