/* See CoreMinimal.h. */
#pragma once

#include "CoreMinimal.h"

struct FFileHelper {
    static bool LoadFileToArray(TArray<uint8> &Bytes, const TCHAR *Path);
};
