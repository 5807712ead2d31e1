// Evaluates fuzzy systems with fuzzylite 6, in a process of its own: systems and points come over stdin.
//
//   S BYTES\n followed by a system as .fll text   -> "ok" or "error TEXT"
//   I BYTES\n the same, as .fis text
//   C BYTES\n the same, as .fcl text
//   P N\n followed by N lines of input values      -> N lines of outputs, all digits
//   R\n                                            -> forgets the last outputs ("ok")
//   T N\n followed by N lines of input values      -> nanoseconds of processor time for each evaluation
#include <fl/Headers.h>

#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

static std::vector<std::vector<double>> points(size_t count, size_t width) {
    std::vector<std::vector<double>> rows(count, std::vector<double>(width));
    for (auto& row : rows)
        for (auto& value : row) {
            std::string word;
            std::cin >> word;
            value = std::stod(word);
        }
    return rows;
}

static double processor_time() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
}

static std::string one_line(std::string text) {
    for (auto& c : text)
        if (c == '\n') c = ' ';
    return text;
}

static std::unique_ptr<fl::Importer> importer(const std::string& word) {
    if (word == "I") return std::unique_ptr<fl::Importer>(new fl::FisImporter);
    if (word == "C") return std::unique_ptr<fl::Importer>(new fl::FclImporter);
    return std::unique_ptr<fl::Importer>(new fl::FllImporter);
}

static void evaluate(fl::Engine& engine, const std::vector<double>& row) {
    for (size_t i = 0; i < row.size(); ++i) engine.getInputVariable(i)->setValue(row[i]);
    engine.process();
}

int main() {
    fl::fuzzylite::setMachEps(std::numeric_limits<double>::min());
    std::unique_ptr<fl::Engine> engine;
    std::string word;
    while (std::cin >> word) {
        size_t count = 0;
        if (word != "R") std::cin >> count;
        try {
            if (word == "S" || word == "I" || word == "C") {
                std::cin.ignore();
                std::string text(count, ' ');
                std::cin.read(&text[0], static_cast<std::streamsize>(count));
                engine.reset(importer(word)->fromString(text));
                std::string status;
                if (!engine->isReady(&status)) {
                    std::printf("error %s\n", one_line(status).c_str());
                } else {
                    std::printf("ok\n");
                }
            } else if (word == "R") {
                engine->restart();
                std::printf("ok\n");
            } else if (word == "P") {
                for (const auto& row : points(count, engine->numberOfInputVariables())) {
                    evaluate(*engine, row);
                    for (size_t i = 0; i < engine->numberOfOutputVariables(); ++i)
                        std::printf("%s%.17g", i ? " " : "", engine->getOutputVariable(i)->getValue());
                    std::printf("\n");
                }
            } else if (word == "T") {
                const auto rows = points(count, engine->numberOfInputVariables());
                double best = 1e99;
                for (int pass = 0; pass < 5; ++pass) {
                    const double start = processor_time();
                    for (const auto& row : rows) evaluate(*engine, row);
                    best = std::min(best, (processor_time() - start) / static_cast<double>(count));
                }
                std::printf("%.17g\n", best);
            }
        } catch (const std::exception& error) {
            std::printf("error %s\n", one_line(error.what()).c_str());
        }
        std::fflush(stdout);
    }
}
