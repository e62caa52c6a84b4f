#pragma once

/// A comment that is wrong, by which tests see that the pages tell of such.
/// @param nowhere  a parameter that there is not.
void SaysWhatIsNot(int number);
