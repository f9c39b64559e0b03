/* See CoreMinimal.h. */
#pragma once

class AActor
{
public:
    template <class T> T *FindComponentByClass() const;
};
